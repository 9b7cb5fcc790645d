"""The IRB1400 at rest: IMU acceleration with the motors off and on. Thesis 5.1.1, Fig. 5.2."""

import os
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import welch

from armside import assets
from armside.sim.instruments.imu import ImuCfg, draw
from armside.sim.robot.flexibility import variant
from armside.sim.robot.model import load_model
from armside.sim.robot.run import run_batch
from armside.sim.robot.virtual_robot import LOG_PERIOD, VirtualRobot

ON = 12.0  # [s]
SEEDS = range(5 if os.environ.get("ARMSIDE_CI") else 3)


def robot():
    return load_model(assets.IRB1400_XML)


def reference(seconds):
    return np.zeros((round(seconds / LOG_PERIOD) + 1, 6))


def readings(recording, seed):
    """Accelerations of the IMU."""
    individual, noise = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    truth = recording.truth
    imu = draw(ImuCfg(clock_offset=0.0), individual)
    signals = truth.time, truth.imu_acceleration, truth.imu_angular_velocity
    return imu.measure(*signals, noise).acceleration


def spectrum(model, seeds=SEEDS):
    """Power spectrum of the accelerometer at rest with motors on, averaged over seeds."""
    loaded = VirtualRobot(model).load(reference(ON))
    power = []
    for seed in seeds:
        (recording,) = run_batch([loaded], [None], [np.random.default_rng(seed)])
        frequency, density = welch(readings(recording, seed), 100.0, nperseg=200, axis=0)
        power.append(density)
    return frequency, np.mean(power, axis=0)


def peaks(frequency, density):
    """(frequency, height relative to the highest) of the local maxima above 5 Hz."""
    inner = np.flatnonzero((density[1:-1] > density[:-2]) & (density[1:-1] > density[2:])) + 1
    inner = inner[frequency[inner] > 5.0]
    return frequency[inner], density[inner] / density[inner].max()


def test_the_spectrum_at_rest_has_a_line_between_25_and_30_hz_that_the_structure_makes():
    """Thesis: a small peak near 27 Hz. Its source is noise without lines; stiffen the arm, and it
    moves away."""
    frequency, flexible = spectrum(robot())
    at, height = peaks(frequency, flexible[:, 1])
    assert height[(at > 25.0) & (at < 30.0)].max() >= 0.2

    stiff = variant(assets.IRB1400_XML, gear_stiffness=1.5, structure_stiffness=3.0)
    stiff.opt.timestep = 0.00025  # its highest mode is beyond what 0.5 ms can follow
    _, stiffened = spectrum(load_model(stiff), seeds=range(1))
    line = (frequency >= 27.0) & (frequency <= 29.0)
    below = (frequency >= 22.0) & (frequency <= 24.0)

    def stands_out(density):
        return density[line, 1].mean() / density[below, 1].mean()

    assert stands_out(flexible) > 10.0
    assert stands_out(stiffened) < 1.0


def test_without_torque_and_encoder_noise_nothing_vibrates():
    model = robot()
    model = replace(model, drives=replace(model.drives, torque_noise=0.0, encoder_noise=0.0))
    recording = VirtualRobot(model).run(reference(2.0), rng=np.random.default_rng(0))
    assert recording.truth.imu_acceleration[500:].std(axis=0).max() < 0.001


def test_switching_on_neither_bumps_nor_drops_the_arm():
    model = robot()
    model = replace(model, drives=replace(model.drives, torque_noise=0.0, encoder_noise=0.0))
    phi = np.array([0.2, 0.6, 0.3, 0.2, -0.4, 0.5])
    held = np.tile(phi, (500, 1))
    truth = VirtualRobot(model).load(held, motors_on_at=1.0).run().truth
    assert np.ptp(truth.tool_position, axis=0).max() < 2e-6
    assert np.abs(truth.motor_torque[:2000]).max() < 1e-3
    assert np.abs(truth.motor_torque[2000:]).max() > 0.5


def test_a_robot_without_brakes_says_so():
    large = load_model(assets.LARGE_ROBOT_XML)
    with pytest.raises(ValueError, match=r"no brakes.*brake_1\.\.6"):
        VirtualRobot(large).load(reference(1.0), motors_on_at=0.5)
