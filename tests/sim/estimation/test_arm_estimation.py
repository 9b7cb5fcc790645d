"""The tool from motor angles and IMU on identified springs: filters in three forms, other units."""

from dataclasses import replace

import numpy as np
import pytest
from tests.claims._estimates import path_error, rigid_path

from armside import kinematics
from armside.assets import LARGE_ROBOT_XML
from armside.ilc.estimation.consistency import normalised_squared
from armside.ilc.estimation.kalman import Smoother
from armside.kinematics.robots import IMU_LINKS
from armside.sim.cell import ToolPose
from armside.sim.estimation.commissioning import UNIDENTIFIED, commission
from armside.sim.estimation.deflection import deflection, explained, residual
from armside.sim.estimation.elasticity import ArmParameters, Elasticity
from armside.sim.estimation.estimator import ToolEstimator, tool_path, validity
from armside.sim.estimation.imu_health import ImuError, repaired
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.rigid_motion import rigid_motion
from armside.sim.laser import Cut, ToolPath, prepare
from armside.sim.laser.loop import first_run
from armside.sim.motion.contour import slot
from armside.sim.robot.model import load_model

from .extended_arm import ExtendedArm, start_covariance
from .one_cut import CUT, IMU, MEASURE, assumed, commissioned, kept, spread
from .wiener import NonCausal

ROBOT = load_model(LARGE_ROBOT_XML)


@pytest.fixture(scope="module")
def known(first):
    """What that cut made known."""
    return commissioned(first)


def estimated(known, run, samples=None):
    """What the estimator of a cut makes of a run, or of its log with other samples."""
    log, samples = run.recording, repaired(run.imu, IMU) if samples is None else samples
    return known.estimator(log.time, log.motor_angle, samples)


@pytest.fixture(scope="module")
def on_gears(first, known):
    """Estimator of the same run on an arm of linear gears alone."""
    arm = ToolPath(structure=False).assumed(prepare(CUT))
    motion = rigid_motion(arm, first.recording.time, first.recording.motor_angle)
    none = np.zeros(6)
    springs = Elasticity(0.6 * arm.stiffness, arm.damping, arm.axes, none, none)
    found = replace(known.parameters, springs=springs)
    return ToolEstimator(arm, found, IMU, motion)


def test_measurement_matrices_are_those_of_the_toolbox(on_gears):
    arm = on_gears.models[0].arm
    robot = kinematics.LARGE_ROBOT
    with_imu = replace(robot, links=(*robot.links, *IMU_LINKS), name="arm with IMU")
    H = kinematics.compile_measurement(with_imu).jacobian(arm.q, np.zeros(6), np.zeros(6))
    assert arm.imu_jacobian[:3] == pytest.approx(H[9:, 12:], abs=1e-9)
    assert arm.imu_jacobian[3:] == pytest.approx(H[6:9, 6:12], abs=1e-9)
    assert arm.imu_gravity == pytest.approx(H[9:, :6], abs=1e-6)


def test_full_filter_deviation_form_and_frequency_domain_agree(first, on_gears):
    log, samples = first.recording, repaired(first.imu, IMU)
    estimate = on_gears(log.time, log.motor_angle, samples)
    full = ExtendedArm(on_gears, kinematics.LARGE_ROBOT)(log.time, log.motor_angle, samples)
    model, own = on_gears.models[0], on_gears.parameters
    motion = on_gears.along
    bent = deflection(motion, own.springs)
    left, bias = residual(samples, explained(motion, bent, IMU), own.clock_offset, own.mounting)
    wiener = NonCausal(model.A, model.intensity, model.C, model.tool)
    step, path = 1.0 / IMU.rate, tool_path(motion, bent)
    start = np.zeros(len(model.A))
    start[-6:] = bias
    smoother = Smoother(model.sampled(step), start_covariance(model), np.isfinite(left))
    forward = smoother(left, start).filtered @ model.tool.T
    spectral = wiener(left - bias, step, model.reading_covariance)

    def on_log(time, columns):
        moved = np.stack([np.interp(log.time, time, c) for c in columns.T], axis=1)
        return moved - moved[:25].mean(axis=0)

    instants = samples.time + own.clock_offset
    causal = path[:, :3] + on_log(instants, forward)[:, :3]
    found = estimate.displacement[:, :3]
    assert spread(on_log(full.time, full.smoothed), found) <= 5e-6
    assert spread(on_log(full.time, full.filtered), causal) <= 5e-6
    assert spread(path[:, :3] + on_log(instants, spectral)[:, :3], found) <= 5e-6


def test_identification_makes_the_estimate_five_times_better_than_the_motors(first, known):
    path = estimated(known, first).displacement
    assert path_error(path, first) <= path_error(rigid_path(first), first) / 5.0


def test_motor_angles_and_wrong_springs_alone_are_not_enough(first, known):
    """Negative control: what the IMU adds is needed."""
    log, estimator = first.recording, known.estimator
    wrong = ArmParameters(known.nominal.on_rigid_structure, 0.0, UNIDENTIFIED, np.zeros(3))
    path = replace(estimator, parameters=wrong)(log.time, log.motor_angle, None).displacement
    assert path_error(path, first) > 0.4 * path_error(rigid_path(first), first)


def test_identified_modes_are_those_of_the_true_arm(first, known):
    rest = first.recording.motor_angle[0]
    true = linearised(nominal_arm(ROBOT, NominalCfg(structure=True)), rest).locked_modes()[:2]
    found = known.estimator.models[0].arm.locked_modes()[:2]
    assert found == pytest.approx(true, rel=0.10)
    gears = linearised(ToolPath(structure=False).assumed(prepare(CUT)), rest)
    assert gears.locked_modes()[0] > 1.2 * true[0]


def test_clock_offset_is_found_to_a_millisecond(known):
    imu = prepare(CUT).plant.imu
    assert imu is not None
    true = imu.unit.clock_offset
    assert known.parameters.clock_offset == pytest.approx(true, abs=1.2e-3)


def test_innovations_have_the_size_the_filter_expects(first, known):
    e = estimated(known, first).innovation
    nis = normalised_squared(e, np.eye(6)[None])
    assert 0.7 * 6 < nis.mean() < 1.5 * 6


def test_no_estimator_reads_the_truth(first, known):
    """The same log with another truth gives the same estimate, bit for bit."""
    log = first.recording
    other = replace(log, truth=replace(log.truth, tool_position=log.truth.tool_position + 1.0))
    runs = first, replace(first, recording=other)
    paths = [estimated(known, run).displacement for run in runs]
    assert np.array_equal(*paths)


def test_readings_that_no_spring_explains_are_not_learned_from(first, known):
    log, samples = first.recording, repaired(first.imu, IMU)
    shaken = samples.acceleration.copy()
    shaken[:, 0] += 500.0 * np.sin(2.0 * np.pi * 10.0 * samples.time) * (samples.time > 0.3)
    found = estimated(known, first, replace(samples, acceleration=shaken))
    assert not validity(found, log.time).weight.any()
    assert validity(estimated(known, first), log.time).weight.all()


def test_single_lost_and_clipped_samples_are_bridged(first, known):
    imu = first.imu
    keep = np.ones(len(imu.time), dtype=bool)
    keep[60:64] = False
    clipped = imu.acceleration_clipped.copy()
    clipped[80] = True
    gappy = kept(replace(imu, acceleration_clipped=clipped), keep)
    runs = first, replace(first, imu=gappy)
    whole, bridged = (estimated(known, run).displacement for run in runs)
    assert 0.0 < spread(whole, bridged) < 5e-6


def test_another_units_clock_and_mounting_are_found_again_on_known_springs(known):
    """The springs of one unit's identification, another unit that started at another time."""
    experiment = prepare(CUT, seed=7)
    other = first_run(experiment)
    assert experiment.plant.imu is not None
    assert other.imu is not None
    unit = experiment.plant.imu.unit
    own = commission(ROBOT, assumed(), IMU, other.recording, other.imu, known=known.parameters)
    assert own.identified is None
    assert own.parameters.clock_offset == pytest.approx(unit.clock_offset, abs=1.5e-3)
    assert abs(known.parameters.clock_offset - unit.clock_offset) > 3e-3
    assert own.parameters.springs is known.parameters.springs
    path = estimated(own, other).displacement
    assert path_error(path, other) <= path_error(rigid_path(other), other) / 5.0


def test_springs_that_leave_too_much_unexplained_are_refused_without_blaming_the_imu(first, known):
    soft = replace(known.parameters.springs, stiffness=0.6 * known.parameters.springs.stiffness)
    others, log = replace(known.parameters, springs=soft), first.recording
    with pytest.raises(ImuError, match=r"[0-9] times as much unexplained as expected; identify"):
        commission(ROBOT, assumed(), IMU, log, first.imu, known=others)


def test_springs_too_soft_for_an_arm_are_no_explanation():
    """A slot whose record a mode of 1 Hz explained best, by the change of gravity sag along it."""
    turned = np.array([0.127362, 0.668404, -0.722337, -0.12347])
    quaternion = tuple((turned / np.linalg.norm(turned)).tolist())
    cut = Cut(
        pose=ToolPose((1.4114, 0.6053, 1.2857), quaternion),
        contour=slot(0.03059, 0.03059 / 3.0),
        speed=0.1398,
        payload=69.5,
        imu=IMU,
    )
    experiment = prepare(cut, seed=190851)
    run = first_run(experiment)
    output = MEASURE.commissioned(experiment, MEASURE.assumed(experiment), run)
    slowest = output.known.estimator.models[0].arm.locked_modes()[0]
    log = run.recording
    true_arm = nominal_arm(experiment.nominal, NominalCfg(structure=True, payload=29.5))
    true = linearised(true_arm, log.motor_angle[0]).locked_modes()[0]
    assert slowest == pytest.approx(true, rel=0.15)
    assert path_error(output(run), run) < 0.2 * path_error(rigid_path(run), run)
