"""Residuals of an IMU show what a twin lacks, and nothing of the unit's own errors."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.instruments.imu import ACCELEROMETER, GYROSCOPE, ImuCfg
from armside.sim.laser import Cut, prepare
from armside.sim.motion.contour import square
from armside.sim.robot.effects import gear_phases
from armside.sim.robot.individual import Individual
from armside.sim.robot.virtual_robot import LOG_PERIOD
from armside.sim.twin.imu_sensor import CUTOFF, ImuComparison, check_imu, clock_offset
from armside.sim.twin.recordings import ImplausibleError, measured
from armside.sim.twin.simulation import RobotDesign
from armside.sim.twin.tool_sensor import imu_kinematics

NOISE_FREE = ImuCfg(
    accelerometer=replace(ACCELEROMETER, noise_density=0.0, bias_walk=0.0),
    gyroscope=replace(GYROSCOPE, noise_density=0.0, bias_walk=0.0),
)


@pytest.fixture(scope="module")
def experiment():
    curve, robot = square(0.03, 0.0045), Individual()
    cut = Cut(pose="p2", contour=curve, speed=0.08, individual=robot, imu=NOISE_FREE)
    return prepare(cut, seed=4)


@pytest.fixture(scope="module")
def run(experiment):
    return experiment.plant.run(np.zeros_like(experiment.loaded.reference))


@pytest.fixture(scope="module")
def comparison(experiment, run):
    return ImuComparison(experiment.nominal, measured(run))


@pytest.fixture(scope="module")
def simulated(experiment, run):
    """Runs of several individuals, and of their design, by the reference of the recorded run."""
    reference, design = run.recording.reference, RobotDesign(experiment.nominal)
    return lambda *twins: design.run(twins, reference, np.zeros_like(reference))


def _rms(residual):
    return float(np.sqrt(np.mean(residual**2)))


def test_errors_of_the_unit_leave_next_to_nothing_of_its_own_run(run, comparison):
    """Bias, clock, mounting, scale and misalignment are projected out; the twin is the robot."""
    own = comparison.residual(run.recording)
    imu, truth = run.imu, run.recording.truth
    at = np.searchsorted(truth.time, np.clip(imu.time, 0.0, truth.time[-1]))
    raw = (imu.acceleration - truth.imu_acceleration[at]) / (0.002 * np.sqrt(50.0))
    assert np.sqrt(np.mean(raw**2)) > 1.0  # the errors are there
    bandwidth = np.sqrt(2.0 * CUTOFF / 100.0)  # of white noise that Q passes
    assert _rms(own) < 0.25 * bandwidth


def test_a_softer_gear_shows(run, comparison, simulated):
    (other,) = simulated(Individual(gear_stiffness=np.full(6, 0.7)))
    assert _rms(comparison.residual(other)) > 4.0 * _rms(comparison.residual(run.recording))


def test_a_change_of_the_twin_changes_the_residual_by_as_much(comparison, simulated):
    base, other = simulated(Individual(), Individual(gear_stiffness=np.full(6, 0.9)))
    change = comparison.residual(base) - comparison.residual(other)
    # Each residual is synchronised anew, which the projection hides to first order.
    assert _rms(comparison.change(base, other) - change) < 0.25 * _rms(change)


def test_kinematic_change_is_the_difference_of_two_motions(experiment):
    """Readings at phi + eps less those at phi: first order in eps, for a swinging wrist and all."""
    time = np.arange(200) * LOG_PERIOD
    phi = 0.3 * np.sin(2.0 * np.pi * time[:, None] * np.arange(1, 7) / 4.0) + 0.2
    eps = 1e-6 * np.cos(2.0 * np.pi * time[:, None] * np.arange(2, 8) / 3.0)
    before = imu_kinematics(experiment.nominal, phi, LOG_PERIOD)
    after = imu_kinematics(experiment.nominal, phi + eps, LOG_PERIOD)
    inner = slice(4, -4)  # one-sided differences at the ends
    difference = (after.reading - before.reading)[inner]
    off = np.linalg.norm(before.change(eps)[inner] - difference)
    assert off < 0.02 * np.linalg.norm(difference)


@pytest.mark.parametrize("offset", [-0.009, 0.0, 0.0073])
def test_the_clock_is_found_under_bias_and_mounting(offset):
    time = np.arange(500) * 0.004
    expected = np.column_stack([np.sin(2.0 * np.pi * f * time) for f in (1.0, 1.7, 2.3)])
    unit_time = np.arange(2, 197) * 0.01
    late = [np.interp(unit_time + offset, time, column) for column in expected.T]
    mounting = np.array([[1.0, 0.02, 0.0], [-0.02, 1.0, 0.01], [0.0, -0.01, 1.0]])
    reading = np.column_stack(late) @ mounting + np.array([0.1, -0.2, 9.8])
    found = clock_offset(unit_time, reading, expected, 0.004, 0.010)
    assert abs(found - offset) < 0.35e-3  # [s], what the sensor's noise below 3 Hz leaves


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"imu": lambda unit: None}, "has no samples of an IMU"),
        ({"acceleration": lambda a: a / 9.82}, "another unit"),
        ({"acceleration": lambda a: a[:, [1, 2, 0]]}, "mounting"),
        ({"acceleration": lambda a: a * np.nan}, "not finite"),
        ({"time": lambda t: t[np.r_[1, 0, 2 : len(t)]]}, "out of order"),
    ],
)
def test_an_imu_that_contradicts_the_robot_is_named(experiment, run, change, said):
    cut = measured(run, "cut-03")
    ((name, by),) = change.items()
    bad = None if name == "imu" else replace(cut.imu, **{name: by(getattr(cut.imu, name))})
    with pytest.raises(ImplausibleError, match=f"cut-03.*{said}"):
        check_imu(experiment.nominal, replace(cut, imu=bad))
    check_imu(experiment.nominal, cut)


def test_gear_errors_of_the_motor_show_as_their_columns_say(
    experiment, run, simulated, monkeypatch
):
    """Quasi-static columns: what a slow gear error excites in the springs is left out."""
    sine = np.zeros((6, 4))
    sine[0, 2] = 0.5
    phases = gear_phases(experiment.nominal)
    none = Individual(gear_error=np.zeros((6, 4)), gear_error_phase=-phases)
    some = replace(none, gear_error=sine)
    base, other = simulated(none, some)
    monkeypatch.setattr("armside.sim.twin.imu_sensor.CUTOFF", 3.0)
    slow = ImuComparison(experiment.nominal, measured(run))
    expected = 0.5 * slow.by_kinematics()["gear_error"][:, :, 2 * 2]
    seen = slow.change(base, other)
    assert np.linalg.norm(seen - expected) < 0.3 * np.linalg.norm(seen)
