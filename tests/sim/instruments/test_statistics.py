"""Statistics of every noise source against the data sheet that its configuration states.

Tolerances are five standard errors of the estimate.
"""

from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.signal import butter, freqz

from armside.sim.instruments import laser_tracker
from armside.sim.instruments.imu import ACCELEROMETER, GYROSCOPE, ImuCfg, Triad, draw
from armside.sim.instruments.laser_tracker import LaserTrackerCfg, set_up

STEP = 5e-4
DEG = np.pi / 180.0
POINT = np.array([1.3166, 0.0014, 1.5992])


def five_errors(n):
    """Five relative standard errors of a standard deviation of n independent samples."""
    return 5.0 / np.sqrt(2.0 * n)


# Data sheets: MTx (MT0100P), thesis 5.1.1; Leica LTD500


OF_BOTH = {"scale_error": 0.03e-2, "misalignment": 0.1 * DEG, "bits": 16}


def test_the_accelerometer_is_that_of_its_data_sheet():
    own = {"noise_density": 0.002, "bandwidth": 30.0, "bias": 0.02, "bias_walk": 1e-4}
    assert asdict(ACCELEROMETER) == pytest.approx(OF_BOTH | own | {"range": 17.0})


def test_the_gyroscope_is_that_of_its_data_sheet():
    own = {"noise_density": 0.1 * DEG, "bandwidth": 40.0, "bias": DEG, "bias_walk": 1e-5}
    assert asdict(GYROSCOPE) == pytest.approx(OF_BOTH | own | {"range": 1200.0 * DEG})


def test_the_unit_is_mounted_and_clocked_as_documented():
    cfg = ImuCfg()
    assert (cfg.rate, cfg.clock_offset, cfg.clock_drift) == (100.0, 0.010, 0.0)
    assert cfg.mounting_error == pytest.approx(0.7 * DEG)
    assert (cfg.accelerometer, cfg.gyroscope) == (ACCELEROMETER, GYROSCOPE)


def test_the_tracker_is_that_of_its_data_sheet():
    cfg = LaserTrackerCfg()
    assert (cfg.rate, cfg.readings_per_target) == (1000.0, 1000)
    assert (cfg.range_noise, cfg.angle_noise) == (5e-6, 1.25e-6)  # 5 um a coordinate at 4 m
    assert (cfg.range_scale_error, cfg.angle_bias) == (5e-6, 5e-6)
    assert cfg.range_resolution == 1.26e-6
    assert cfg.angle_resolution == pytest.approx(0.14 * DEG / 3600.0)
    assert cfg.acceptance_angle == pytest.approx(30.0 * DEG)
    assert cfg.target_offset == (0.0, 0.0, 0.0)
    distance = np.linalg.norm(np.array(cfg.position) - POINT)
    assert distance == pytest.approx(4.0, abs=0.2)
    assert pytest.approx(DEG / 3600.0) == laser_tracker.ARCSEC


# IMU


@pytest.mark.parametrize("cfg", [ACCELEROMETER, GYROSCOPE], ids=["accelerometer", "gyroscope"])
def test_noise_of_a_triad_has_its_density_through_its_low_pass(cfg):
    """Variance = density^2 times the integral of the filter's power gain up to half the rate."""
    triad = Triad(cfg=cfg, sensitivity=np.eye(3), bias=np.zeros(3))
    noise = triad.filtered(np.zeros((400_000, 3)), STEP, np.random.default_rng(1))
    b, a = butter(2, cfg.bandwidth, fs=1.0 / STEP)
    frequency, gain = freqz(b, a, worN=20_000, fs=1.0 / STEP)
    power = cfg.noise_density**2 * np.trapezoid(np.abs(gain) ** 2, frequency)
    n = noise.size * STEP * 2.0 * cfg.bandwidth  # independent samples
    assert noise.std() == pytest.approx(np.sqrt(power), rel=five_errors(n))
    assert five_errors(n) < 0.025
    axes = noise.std(axis=0) / np.sqrt(power)
    assert axes == pytest.approx(np.ones(3), rel=five_errors(n / 3))
    assert np.abs(np.corrcoef(noise.T)[np.triu_indices(3, 1)]).max() < 5 / np.sqrt(n / 3)


@pytest.mark.parametrize("cfg", [ACCELEROMETER, GYROSCOPE], ids=["accelerometer", "gyroscope"])
def test_the_bias_walks_by_its_density_and_stays_within_the_range(cfg):
    walking = replace(cfg, bias_walk=0.05 * cfg.range / 10.0, bits=0)
    triad = Triad(cfg=walking, sensitivity=np.eye(3), bias=np.array([0.1, 0.0, -0.1]))
    rngs = map(np.random.default_rng, range(1000))
    runs = [triad.digitised(np.zeros((200, 3)), 0.5, rng)[0] for rng in rngs]
    ends = np.array(runs)[:, [0, -1]]
    assert ends[:, 0] == pytest.approx(np.tile(triad.bias, (1000, 1)))
    spread = (ends[:, 1] - triad.bias).std()
    assert spread == pytest.approx(walking.bias_walk * np.sqrt(199 * 0.5), rel=five_errors(3000))


def test_every_constant_error_of_a_unit_spreads_as_configured():
    cfg = replace(ImuCfg(), clock_drift=2e-5)
    units = [draw(cfg, np.random.default_rng(seed)) for seed in range(2500)]
    off = ~np.eye(3, dtype=bool)
    for name in ("accelerometer", "gyroscope"):
        triads, own = [getattr(unit, name) for unit in units], getattr(cfg, name)
        matrices = np.array([triad.sensitivity for triad in triads]) - np.eye(3)
        samples = {
            "bias": np.array([triad.bias for triad in triads]),
            "scale_error": np.diagonal(matrices, axis1=1, axis2=2),
            "misalignment": matrices[:, off],
        }
        for kind, values in samples.items():
            expected = getattr(own, kind)
            assert values.std() == pytest.approx(expected, rel=five_errors(values.size)), kind
            assert abs(values.mean()) < 5 * expected / np.sqrt(values.size), kind
    # a rotation by a small vector: its antisymmetric part
    R = np.array([unit.R_site_imu for unit in units])
    vector = 0.5 * np.stack(
        [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]]
    )
    assert vector.std() == pytest.approx(cfg.mounting_error, rel=five_errors(vector.size))
    drift = np.array([unit.clock_drift for unit in units])
    assert drift.std() == pytest.approx(2e-5, rel=five_errors(len(units)))
    offset = np.array([unit.clock_offset for unit in units])
    assert np.abs(offset).max() <= 0.010
    assert np.abs(offset).max() > 0.0099
    assert offset.std() == pytest.approx(0.010 / np.sqrt(3), rel=five_errors(len(units)))
    assert abs(offset.mean()) < 5 * 0.010 / np.sqrt(3 * len(units))


def test_a_clipped_reading_is_one_at_the_end_of_its_range():
    for cfg in (ACCELEROMETER, GYROSCOPE):
        triad = Triad(cfg=replace(cfg, bias_walk=0.0), sensitivity=np.eye(3), bias=np.zeros(3))
        levels = np.array([-1.5, -1.001, -0.99, 0.0, 0.99, 1.001, 1.5])[:, None] * cfg.range
        read, clipped = triad.digitised(np.repeat(levels, 3, axis=1), 0.01, np.random.default_rng())
        assert clipped[:, 0].tolist() == [True, True, False, False, False, True, True]
        assert read[[0, 1, 5, 6], 0] == pytest.approx(cfg.range * np.array([-1, -1, 1, 1]))
        count = 2.0 * cfg.range / 2**16
        assert np.abs(read[2:5, 0] - levels[2:5, 0]).max() <= 0.5 * count * (1 + 1e-9)
        assert triad.cfg.resolution == pytest.approx(count)
        whole = read[2:5, 0] / count
        assert whole == pytest.approx(np.rint(whole), rel=0, abs=1e-9)


# Tracker


def polar(p):
    distance = np.linalg.norm(p, axis=-1)
    return np.stack([distance, np.arctan2(p[..., 1], p[..., 0]), np.arcsin(p[..., 2] / distance)])


def test_readings_of_the_tracker_scatter_by_noise_and_resolution():
    tracker, n = set_up(LaserTrackerCfg(), np.random.default_rng(0)), 60_000
    readings = polar(tracker.read(np.tile(POINT, (n, 1)), np.random.default_rng(1)))
    cfg = tracker.cfg
    noise = np.array([cfg.range_noise, cfg.angle_noise, cfg.angle_noise])
    steps = np.array([cfg.range_resolution, cfg.angle_resolution, cfg.angle_resolution])
    expected = np.sqrt(noise**2 + steps**2 / 12.0)
    assert readings.std(axis=1) == pytest.approx(expected, rel=five_errors(n))


def test_set_ups_of_the_tracker_differ_by_scale_and_angle_bias():
    """The error of a set-up is what the mean of many readings of it is off by."""
    cfg = replace(LaserTrackerCfg(), readings_per_target=1)
    set_ups = [set_up(cfg, np.random.default_rng(seed)) for seed in range(1500)]
    bias = np.array([tracker.bias for tracker in set_ups])
    limit = five_errors(len(set_ups))
    assert bias.std(axis=0) == pytest.approx([5e-6, 5e-6, 5e-6], rel=limit)
    silent = replace(cfg, range_noise=0.0, angle_noise=0.0, range_resolution=0.0)
    tracker = replace(set_ups[0], cfg=replace(silent, angle_resolution=0.0))
    exact = replace(tracker, bias=np.zeros(3))
    off = polar(tracker.read(POINT[None], np.random.default_rng()))[:, 0]
    true = polar(exact.read(POINT[None], np.random.default_rng()))[:, 0]
    assert off[0] / true[0] - 1.0 == pytest.approx(bias[0, 0], rel=1e-6)
    assert off[1:] - true[1:] == pytest.approx(bias[0, 1:], rel=1e-6)


def test_the_tracker_counts_azimuth_from_its_heading_and_elevation_upwards():
    cfg = LaserTrackerCfg(
        range_noise=0.0, angle_noise=0.0, range_scale_error=0.0, angle_bias=0.0,
        range_resolution=0.0, angle_resolution=0.0,
    )  # fmt: skip
    tracker = set_up(cfg, np.random.default_rng(0))
    ahead = np.array([np.cos(cfg.heading), np.sin(cfg.heading), 0.0])
    left = np.array([-ahead[1], ahead[0], 0.0])
    where = np.array(cfg.position) + np.array([2 * ahead, 3 * left, [0.0, 0.0, 4.0]])
    own = tracker.read(where, np.random.default_rng())
    assert own == pytest.approx(np.diag([2.0, 3.0, 4.0]), abs=1e-12)
    assert tracker.registration.to_base(own) == pytest.approx(where, abs=1e-9)
