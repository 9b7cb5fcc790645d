"""Transmission error of a synthetic arm, from an IMU or a tracker, and of the AUBO i5."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armside.kinematics import CATALOGUE
from armside.sim.gears import GearsCfg, analyse_gears
from armside.sim.gears.judgement import JUDGED_FROM, fused
from armside.sim.recordings import Stream, read_motion
from armside.sim.recordings.alignment.encoder_motion import lowpass

CFG = GearsCfg(largest_order=200.0)
SETS = os.environ.get("ARMSIDE_MEASUREMENTS")
AUBO = Path(SETS or ".") / "aubo_i5"
DAYS = ("20200922", "20201015", "20201016")
DESTROYED = 2.0
"""[Hz] Nothing of a tracker above it may enter."""
SETTLED = 1.0
"""[s] In which the low-pass of the alignment forgets what comes after."""


def strongest(found, joint):
    return next(term for term in found.terms if term.joint == joint)


def assert_terms(found, scenes):
    """Orders within one, amplitudes within 10 %, phases within 0.2 rad at the middle of the travel,
    and amplitudes within four of their standard deviations."""
    middle = (0.0, 0.8, -1.0)
    for joint in range(3):
        term = strongest(found, joint + 1)
        order, amplitude = scenes.ORDERS[joint], scenes.AMPLITUDE[joint]
        assert abs(term.order - order) < 1.0
        assert abs(term.amplitude - amplitude) < 0.1 * amplitude
        assert abs(term.amplitude - amplitude) < 4.0 * term.amplitude_deviation + 0.02 * amplitude
        phase = term.phase + term.order * middle[joint]
        off = phase - scenes.PHASE[joint] - order * middle[joint]
        assert abs((off + np.pi) % (2.0 * np.pi) - np.pi) < 0.2


def test_imu_alone_finds_orders_amplitudes_and_phases(analysis, scenes):
    assert analysis.sensor == "imu"
    assert_terms(analysis.found, scenes)


def test_clocks_mounting_scale_and_lever_are_found(analysis, scenes):
    for one, offset, tracker in zip(analysis.aligned, (0.1, 0.15), (-3.0, 800.0), strict=True):
        assert abs(one.imu.gyro_delay - offset) < 1e-3
        assert abs(one.imu.accelerometer_delay - offset) < 1e-3
        assert np.abs(np.linalg.svd(one.imu.M_gyro)[1] - 1.02).max() < 2e-3
        turn = one.imu.R_imu_tool @ scenes.MOUNTING.T
        assert np.degrees(np.arccos((np.trace(turn) - 1.0) / 2.0)) < 0.1
        # 20 mm turn at 0.3 rad/s^2 by no more than 6 mm/s^2, a fifth of the noise
        assert np.abs(one.imu.lever - scenes.LEVER).max() < 20e-3
        assert np.abs(one.tracker.target - scenes.TARGET).max() < 1e-3
        assert abs(one.tracker.offset - tracker * (1.0 + one.tracker.rate)) < 25e-3
    assert analysis.aligned[0].tracker.rate == pytest.approx(30e-6, abs=20e-6)
    assert analysis.aligned[1].tracker.rate == pytest.approx(-1e-3, abs=20e-6)


def test_error_learned_elsewhere_explains_the_tracker_and_sham_orders_do_not(analysis):
    assert len(analysis.judgements) == 2
    for one in analysis.judgements:
        assert one.recording not in one.learned_from
        assert one.tool.pooled < 0.5
        assert one.sham_tool.pooled > 0.98
        assert one.sensor < 0.95
        assert one.sham_sensor > 0.98


def test_tracker_finds_the_same(recordings, scenes):
    done = analyse_gears(scenes.ARM, recordings, replace(CFG, sensor="tracker"))
    assert_terms(done.found, scenes)


def destroyed(one, aligned):
    """The recording with noise in place of what the tracker saw above 2 Hz, and with its last point
    held from the judged half on."""
    time, values = one.tracker.time, one.tracker.values
    rate = 1.0 / float(np.median(np.diff(time)))
    slow = lowpass(values, DESTROYED, rate)
    noise = (values - slow).std(axis=0) * np.random.default_rng(0).standard_normal(values.shape)
    values = slow + noise - lowpass(noise, DESTROYED, rate)
    clock = aligned.tracker.clock(aligned.motion)
    judged = time > clock[int(JUDGED_FROM * len(clock))] + SETTLED
    values = np.where(judged[:, None], values[~judged][-1], values)
    return replace(one, tracker=Stream(time, values))


def assert_only_clock_base_and_tool_enter(arm, recordings, cfg, analysis):
    """What is learned is the same to the last bit, and the estimate of the tool's error within 2 %,
    with the IMU smoothed in and without, when the tracker's fast part and second half are
    destroyed."""
    pairs = zip(recordings, analysis.aligned, strict=True)
    ruined = analyse_gears(arm, [destroyed(*pair) for pair in pairs], cfg)
    for before, after in zip(analysis.judgements, ruined.judgements, strict=True):
        assert np.array_equal(before.found.coefficients, after.found.coefficients)
        assert np.array_equal(before.found.orders, after.found.orders)
    both = zip(analysis.aligned, ruined.aligned, analysis.judgements, strict=True)
    for before, after, judged in both:
        own = [judged.found.tool_error(one.motion, one.target) for one in (before, after)]
        assert np.linalg.norm(own[0] - own[1]) < 0.02 * np.linalg.norm(own[0])
        own = [fused(one, judged.found) for one in (before, after)]
        assert np.linalg.norm(own[0] - own[1]) < 0.02 * np.linalg.norm(own[0])


def test_nothing_of_the_judged_tracker_but_clock_base_and_tool_enters(analysis, recordings, scenes):
    assert_only_clock_base_and_tool_enter(scenes.ARM, recordings, CFG, analysis)


def test_smoothed_imu_follows_a_vibration_that_is_no_gear_error(scenes):
    one = scenes.recording(scenes.Scene(4, shake=150e-6))
    (judged,) = analyse_gears(scenes.ARM, [one], CFG).judgements
    assert judged.tool
    assert judged.smoothed
    assert judged.tool.pooled > 0.5
    assert judged.smoothed.pooled < 0.75 * judged.tool.pooled


@pytest.mark.skipif(not AUBO.is_dir(), reason="ARMSIDE_MEASUREMENTS names no folder aubo_i5")
def test_aubo_shows_two_periods_per_motor_turn_on_each_day():
    recordings, arm = [read_motion(AUBO / day) for day in DAYS], CATALOGUE["aubo_i5"]
    done = analyse_gears(arm, recordings)
    ratios = [one.tool.pooled for one in done.judgements if one.tool]
    shams = [one.sham_tool.pooled for one in done.judgements if one.sham_tool]
    assert len(ratios) == len(shams) == 3
    assert max(ratios) <= 0.78
    assert sorted(ratios)[1] <= 0.70
    assert min(shams) >= 0.98
    assert max(one.smoothed.pooled for one in done.judgements if one.smoothed) <= 0.70
    for joint, orders in enumerate(((240, 242),) * 3 + ((200, 202),) * 2 + ((100, 101, 200),)):
        peak = done.scan.orders[joint][np.argmax(done.scan.explained[joint])]
        assert min(abs(peak - order) for order in orders) <= 2.0
    imus = [one.imu for one in done.aligned if one.imu]
    assert np.ptp([np.linalg.svd(imu.M_gyro)[1] for imu in imus], axis=0).max() <= 0.005
    for imu in imus[1:]:
        turn = imu.R_imu_tool @ imus[0].R_imu_tool.T
        assert np.degrees(np.arccos(min(1.0, (np.trace(turn) - 1.0) / 2.0))) <= 0.2
    assert_only_clock_base_and_tool_enter(arm, recordings, GearsCfg(), done)
