"""The tracker's readings scatter as configured, its frame is found, and a lost beam is marked."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.instruments.laser_tracker import LaserTrackerCfg, best_fit, set_up

NOISE_ONLY = LaserTrackerCfg(
    range_scale_error=0.0, angle_bias=0.0, range_resolution=0.0, angle_resolution=0.0
)
SILENT = replace(NOISE_ONLY, range_noise=0.0, angle_noise=0.0)
POINT = np.array([1.3166, 0.0014, 1.5992])
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def rng(seed=0):
    return np.random.default_rng(seed)


def polar(p):
    distance = np.linalg.norm(p, axis=-1)
    return distance, np.arctan2(p[:, 1], p[:, 0]), np.arcsin(p[:, 2] / distance)


def turned(angle, axis=2):
    q = np.zeros((len(angle), 4))
    q[:, 0], q[:, 1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def expected_residual(cfg):
    """Root mean square of a coordinate, by propagating polar noise to each reference target."""
    to_target = np.array(cfg.reference_targets) - np.array(cfg.position)
    distance = np.linalg.norm(to_target, axis=1)
    level = np.linalg.norm(to_target[:, :2], axis=1)
    variance = cfg.range_noise**2 + cfg.angle_noise**2 * (distance**2 + level**2)
    return np.sqrt(np.mean(variance) / 3)


def test_the_registration_residual_equals_the_configured_noise_over_1e4_readings():
    cfg = replace(LaserTrackerCfg(), range_scale_error=0.0, angle_bias=0.0)
    cfg = replace(cfg, readings_per_target=1250)
    assert cfg.readings_per_target * len(cfg.reference_targets) == 10_000
    residual = set_up(cfg, rng()).registration.residual
    assert residual == pytest.approx(expected_residual(cfg), rel=0.1)


def test_a_set_up_error_shows_in_the_residual():
    cfg = replace(LaserTrackerCfg(), range_scale_error=50e-6)
    assert set_up(cfg, rng(3)).registration.residual > 1.5 * expected_residual(cfg)


def test_without_noise_the_frame_is_found_to_rounding():
    tracker = set_up(SILENT, rng())
    points = rng(4).uniform([1, -1, 1], [2, 1, 2], (50, 3))
    back = tracker.registration.to_base(tracker.read(points, rng()))
    # Rounding of the sums over 8000 readings of size 4 m.
    np.testing.assert_allclose(back, points, rtol=0, atol=1e-12)
    assert tracker.registration.residual < 1e-12


def test_readings_are_whole_steps_of_the_resolution():
    cfg = LaserTrackerCfg()
    distance, azimuth, _ = polar(set_up(cfg, rng()).read(np.tile(POINT, (100, 1)), rng(1)))
    for value, step in ((distance, cfg.range_resolution), (azimuth, cfg.angle_resolution)):
        counts = value / step
        np.testing.assert_allclose(counts, np.rint(counts), rtol=0, atol=1e-6)


def test_best_fit_recovers_a_rigid_motion_and_never_a_reflection():
    a = rng(5).normal(size=(6, 3))
    R = np.linalg.qr(rng(6).normal(size=(3, 3)))[0]
    R *= np.linalg.det(R)
    fit = best_fit(a, a @ R.T + [1, 2, 3])
    np.testing.assert_allclose(fit.R_base_tracker, R, rtol=0, atol=1e-14)
    np.testing.assert_allclose(fit.p_base_tracker, [1, 2, 3], rtol=0, atol=1e-14)
    mirrored = best_fit(a, a * [1, 1, -1])
    assert np.linalg.det(mirrored.R_base_tracker) == pytest.approx(1.0)
    assert mirrored.residual > 0.1


def test_registration_needs_three_targets_off_a_line():
    line = np.outer(np.arange(5.0), [1.0, 2.0, 3.0])
    for points in (line, line[:2]):
        with pytest.raises(ValueError, match="not on one line"):
            best_fit(points, points)


def measured(cfg, q, path=POINT, seed=0):
    """Samples of a tool with orientations (M, 4) along a path, at the rate of the physics."""
    time, n = np.arange(len(q)) * 5e-4, len(q)
    return set_up(cfg, rng(seed)).measure(time, np.broadcast_to(path, (n, 3)), q, rng(seed))


def test_a_run_is_sampled_at_1000_hz_from_a_2000_hz_record():
    time = np.arange(2001) * 5e-4
    path = POINT + 0.005 * np.stack([np.cos(time), np.sin(time), 0 * time], axis=1)
    samples = measured(SILENT, np.tile(UPRIGHT, (2001, 1)), path)
    np.testing.assert_array_equal(samples.time, time[::2])
    np.testing.assert_allclose(samples.position, path[::2], rtol=0, atol=1e-12)
    assert samples.valid.all()


def test_a_rate_that_does_not_divide_the_record_is_refused():
    with pytest.raises(ValueError, match="must divide the 2000 Hz"):
        measured(replace(SILENT, rate=300.0), np.tile(UPRIGHT, (100, 1)))


def test_a_beam_outside_the_acceptance_angle_is_lost_marked_and_stays_lost():
    time = np.arange(2001) * 5e-4
    angle = 1.2 * np.sin(np.pi * time)  # turns away from the tracker and back
    samples = measured(NOISE_ONLY, turned(angle))
    lost = np.flatnonzero(~samples.valid)
    # The reflector faced the tracker; the angle to the beam is found here by turning that beam.
    beam = np.array(NOISE_ONLY.position) - POINT
    beam /= np.linalg.norm(beam)
    level = beam[0] ** 2 + beam[1] ** 2
    away = np.arccos(np.minimum(level * np.cos(angle[::2]) + beam[2] ** 2, 1.0))
    assert lost[0] == np.flatnonzero(away > np.deg2rad(30.0))[0]
    np.testing.assert_array_equal(lost, np.arange(lost[0], 1001))
    assert np.isnan(samples.position[lost]).all()
    assert np.isfinite(samples.position[: lost[0]]).all()


def test_an_offset_target_moves_by_the_tilt_of_the_tool_times_its_lever():
    time = np.arange(2001) * 5e-4
    tilt = 1e-3 * np.sin(2 * np.pi * time)
    cfg = replace(SILENT, target_offset=(0.1, 0.0, 0.0))
    samples = measured(cfg, turned(tilt))
    seen = samples.position - POINT
    np.testing.assert_allclose(seen[:, 1], 0.1 * np.sin(tilt[::2]), rtol=0, atol=1e-12)
    np.testing.assert_allclose(seen[:, 0], 0.1 * (np.cos(tilt[::2]) - 1), rtol=0, atol=1e-12)


def test_the_same_seed_gives_the_same_bits():
    def run(seed):
        return measured(LaserTrackerCfg(), np.tile(UPRIGHT, (201, 1)), seed=seed).position

    np.testing.assert_array_equal(run(1), run(1))
    assert np.any(run(1) != run(2))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate": 0.0}, "rate must be > 0"),
        ({"range_noise": -1.0}, "range_noise must be >= 0"),
        ({"acceptance_angle": 0.0}, "acceptance_angle"),
        ({"readings_per_target": 0}, "readings_per_target"),
    ],
)
def test_a_configuration_checks_itself(change, message):
    with pytest.raises(ValueError, match=message):
        replace(LaserTrackerCfg(), **change)
