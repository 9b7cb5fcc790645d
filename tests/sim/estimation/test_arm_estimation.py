"""The arm from motor angles and IMU: observer, filters in three forms, identification, faults."""

from dataclasses import replace

import numpy as np
import pytest

from armside import kinematics
from armside.assets import LARGE_ROBOT_XML
from armside.ilc.estimation.consistency import normalised_squared
from armside.ilc.filters import butterworth, recursion
from armside.kinematics.robots import IMU_LINKS
from armside.sim.cell import ToolPose
from armside.sim.cut.contour import slot
from armside.sim.cut.timing import PathLimits
from armside.sim.estimation.arm_estimator import Estimate
from armside.sim.estimation.arm_filter import arm_filter
from armside.sim.estimation.arm_identification import prepared, with_nonlinear_residual
from armside.sim.estimation.commissioning import Commissioning, OnFault, commission
from armside.sim.estimation.extended_arm import ExtendedArm
from armside.sim.estimation.imu_health import Fault, ImuError, repaired
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.observer import dragged, observe
from armside.sim.estimation.plausibility import EstimateError
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, ToolPath, prepare
from armside.sim.laser.learning import first_run
from armside.sim.laser.path_error import path_error, rigid_path
from armside.sim.robot.effects import Effect
from armside.sim.robot.model import load_model

IMU = ImuCfg()
CUT = Cut(pose="p2", without=tuple(Effect), imu=IMU)
MEASURE = ToolPath()


@pytest.fixture(scope="module")
def first():
    """One cut before learning."""
    return first_run(prepare(CUT))


def assumed():
    """The arm with stiffnesses that are wrong."""
    return MEASURE.assumed(prepare(CUT))


def commissioned(run, cfg=Commissioning()):
    robot = load_model(LARGE_ROBOT_XML)
    return commission(robot, assumed(), IMU, run.recording, run.imu, cfg)


@pytest.fixture(scope="module")
def known(first):
    """What that cut made known."""
    return commissioned(first)


def spread(a, b):
    """3D RMS distance of two paths from rest [m]."""
    return float(np.sqrt(np.square((a - b)[:, :3]).sum(axis=1).mean()))


def test_observer_with_true_structure_and_exact_angles_is_the_truth(first):
    truth = first.recording.truth
    arm = nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(structure=True))
    rate = np.gradient(truth.motor_angle, truth.time[1], axis=0)
    motion = dragged(arm, truth.motor_angle, rate)
    every = 8
    path = relative_to_start(motion.tool_position[::every])
    true = relative_to_start(truth.tool_position[::every])
    assert spread(path, true) <= 0.5e-6


def test_linearised_arm_is_the_rollout_linearised():
    """Same springs, coupled; a motion of 0.1 mrad."""
    arm = nominal_arm(load_model(LARGE_ROBOT_XML))
    K = arm.stiffness.copy()
    K[1, 2] = K[2, 1] = -0.1 * K[2, 2]
    arm = arm.with_springs(K, arm.damping)
    phi0 = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
    t = np.arange(2000) * arm.mj.opt.timestep
    phi = phi0 + 1e-4 * np.sin(2 * np.pi * 3.0 * t)[:, None] ** 3
    motion = dragged(arm, phi, np.gradient(phi, t[1], axis=0))
    from armside.ilc.estimation.process import first_order_hold, simulate

    A, B = linearised(arm, phi0).dynamics()
    inputs = np.hstack((phi - phi0, np.gradient(phi, t[1], axis=0)))
    x = simulate(*first_order_hold(A, B, t[1]), inputs)
    assert np.abs(motion.q - motion.q[0] - x[:, :6]).max() < 0.02 * np.abs(x[:, :6]).max()


def test_linear_arm_with_its_nonlinear_residual_reads_what_the_rollout_reads():
    """A circle of the robot at 100 mm/s: at twice its frequency, where linear models are blind."""
    cut = replace(CUT, speed=0.1, limits=PathLimits(acceleration=2.2))
    # As soft as structure and gears together, so that its lowest modes are where the robot's are.
    arm = nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(stiffness=0.4))
    made = first_run(prepare(cut))
    log = made.recording
    motion = observe(arm, log.motor_angle, float(log.time[1]))
    model = arm_filter(linearised(arm, log.motor_angle[0]), IMU)
    run = prepared(arm, log.time, log.motor_angle, repaired(made.imu, IMU))
    run = with_nonlinear_residual(arm, model, run)
    rollout = np.hstack((motion.imu_acceleration, motion.imu_angular_velocity))
    seen = np.hstack(
        [
            low_passed(part - part[0], triad.bandwidth, motion.time[1])[::8]
            for part, triad in zip(
                np.split(rollout, 2, axis=1),
                (IMU.accelerometer, IMU.gyroscope),
                strict=True,
            )
        ]
    )

    def missing(nonlinear):
        states = model.simulated(run.phi, run.phi_dot, nonlinear, run.period)
        return np.sqrt(np.square(model.readings(states)[0] - seen).mean(axis=0))

    none = replace(
        run.nonlinear, torque=0.0 * run.nonlinear.torque, reading=0.0 * run.nonlinear.reading
    )
    noise = IMU.accelerometer.noise_density * np.sqrt(IMU.accelerometer.bandwidth)
    assert missing(none)[:3].max() > 2.0 * noise
    assert missing(run.nonlinear)[:3].max() < noise  # the time step of rollout and low-pass


def low_passed(signal, bandwidth, step):
    """Second-order Butterworth, one way, as the unit has it."""
    for b, a in butterworth(bandwidth, step, 2):
        signal = recursion(b, a, np.ascontiguousarray(signal))
    return signal


def test_measurement_matrices_are_those_of_the_toolbox(known):
    arm = known.estimator.model.arm
    robot = kinematics.LARGE_ROBOT
    with_imu = replace(robot, links=(*robot.links, *IMU_LINKS), name="arm with IMU")
    H = kinematics.compile_measurement(with_imu).jacobian(arm.q, np.zeros(6), np.zeros(6))
    assert arm.imu_jacobian[:3] == pytest.approx(H[9:, 12:], abs=1e-9)
    assert arm.imu_jacobian[3:] == pytest.approx(H[6:9, 6:12], abs=1e-9)
    assert arm.imu_gravity == pytest.approx(H[9:, :6], abs=1e-6)


def test_full_filter_deviation_form_and_frequency_domain_agree(first, known):
    log = first.recording
    samples = repaired(first.imu, IMU)
    form = {
        kind: known.estimator(log.time, log.motor_angle, samples, kind).displacement
        for kind in Estimate
    }
    full = ExtendedArm(known.estimator, kinematics.LARGE_ROBOT)
    estimate = full(log.time, log.motor_angle, samples)

    def on_log(path):
        return np.stack([np.interp(log.time, estimate.time, c) for c in path.T], axis=1)

    smoother = form[Estimate.SMOOTHER]
    assert spread(on_log(estimate.smoothed), smoother[:, :3]) <= 5e-6
    assert spread(on_log(estimate.filtered), form[Estimate.FILTER][:, :3]) <= 5e-6
    assert spread(form[Estimate.WIENER], smoother) <= 5e-6


def test_identification_makes_the_estimate_five_times_better_than_the_motors(first, known):
    log = first.recording
    estimate = known.estimator(log.time, log.motor_angle, repaired(first.imu, IMU))
    assert path_error(estimate.displacement, first) <= path_error(rigid_path(first), first) / 5.0


def test_identified_modes_are_those_of_the_true_arm(first, known):
    rest = first.recording.motor_angle[0]
    true = linearised(nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(structure=True)), rest)
    found = known.estimator.model.arm.locked_modes()[:2]
    assert found == pytest.approx(true.locked_modes()[:2], rel=0.10)
    assert linearised(assumed(), rest).locked_modes()[0] > 1.2 * true.locked_modes()[0]


def test_clock_offset_is_found_to_a_millisecond(known):
    true = prepare(CUT).plant.imu.unit.clock_offset
    assert known.springs.clock_offset == pytest.approx(true, abs=1.2e-3)


def test_innovations_have_the_size_the_filter_expects(first, known):
    log = first.recording
    e = known.estimator(log.time, log.motor_angle, repaired(first.imu, IMU)).innovation
    nis = normalised_squared(e, np.eye(6)[None])
    assert 0.7 * 6 < nis.mean() < 1.5 * 6


def test_no_estimator_reads_the_truth(first, known):
    """The same log with another truth gives the same estimate, bit for bit."""
    log = first.recording
    other = replace(log, truth=replace(log.truth, tool_position=log.truth.tool_position + 1.0))
    samples = repaired(first.imu, IMU)
    paths = [known.estimator(r.time, r.motor_angle, samples).displacement for r in (log, other)]
    assert np.array_equal(*paths)


def test_readings_that_no_spring_explains_give_no_estimate(first, known):
    log, samples = first.recording, repaired(first.imu, IMU)
    shaken = samples.acceleration.copy()
    shaken[:, 0] += 500.0 * np.sin(2.0 * np.pi * 10.0 * samples.time) * (samples.time > 0.3)
    with pytest.raises(EstimateError, match="off what the motors show"):
        known.estimator(log.time, log.motor_angle, replace(samples, acceleration=shaken))


def test_single_lost_and_clipped_samples_are_bridged(first, known):
    log, imu = first.recording, first.imu
    keep = np.ones(len(imu.time), dtype=bool)
    keep[60:64] = False
    clipped = imu.acceleration_clipped.copy()
    clipped[80] = True
    gappy = _kept(replace(imu, acceleration_clipped=clipped), keep)
    whole, bridged = (
        known.estimator(log.time, log.motor_angle, repaired(s, IMU)).displacement
        for s in (imu, gappy)
    )
    assert 0.0 < spread(whole, bridged) < 5e-6


def _kept(imu, keep):
    return replace(
        imu,
        **{
            name: getattr(imu, name)[keep]
            for name in (
                "time",
                "acceleration",
                "angular_velocity",
                "acceleration_clipped",
                "angular_velocity_clipped",
            )
        },
    )


def _disordered(imu):
    time = imu.time.copy()
    time[50:52] = time[51], time[50]
    return replace(imu, time=time)


def _dead(imu):
    still = imu.angular_velocity.copy()
    still[:, 2] = 0.01
    return replace(imu, angular_velocity=still)


def _clipping(imu):
    clipped = imu.acceleration_clipped.copy()
    clipped[::3] = True
    return replace(imu, acceleration_clipped=clipped)


def _broken(imu):
    broken = imu.acceleration.copy()
    broken[7] = np.nan
    return replace(imu, acceleration=broken)


FAULTS = {
    Fault.OUT_OF_ORDER: _disordered,
    Fault.DEAD: _dead,
    Fault.CLIPPED: _clipping,
    Fault.NOT_FINITE: _broken,
    Fault.LOST: lambda imu: _kept(imu, np.arange(len(imu.time)) % 3 > 0),
    Fault.TOO_SHORT: lambda imu: _kept(imu, np.arange(len(imu.time)) < 20),
    Fault.UNEVEN: lambda imu: replace(imu, time=imu.time * 1.02),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_imu_is_named_and_learning_refuses_to_start(fault, first):
    bad = replace(first, imu=FAULTS[fault](first.imu))
    with pytest.raises(ImuError, match=fault.value) as raised:
        commissioned(bad)
    assert raised.value.fault is fault


def test_or_it_goes_on_without_the_imu_if_told_so(first):
    bad = replace(first, imu=_dead(first.imu))
    known = commissioned(bad, Commissioning(on_fault=OnFault.GO_ON))
    assert known.fault is not None
    assert known.fault.fault is Fault.DEAD
    assert known.identified is None


@pytest.mark.parametrize(
    "turn",
    [
        (0.0, 0.0, 0.0, 1.2, 0.8, 2.0),
        (0.0, 0.3, -0.3, 0.0, 0.3, 0.0),
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.5),
    ],
)
def test_a_model_of_another_robot_is_refused(turn, first):
    """The same arm in another posture, or with its flange turned: another robot to the IMU."""
    turned = first.recording.motor_angle + np.array(turn)
    other = replace(first, recording=replace(first.recording, motor_angle=turned))
    with pytest.raises(ImuError, match=Fault.MODEL.value):
        commissioned(other)


def test_another_units_clock_and_mounting_are_found_again_on_known_springs(known):
    """The springs of one unit's identification, another unit that started at another time."""
    experiment = prepare(CUT, seed=7)
    other = first_run(experiment)
    unit = experiment.plant.imu.unit
    own = commission(
        load_model(LARGE_ROBOT_XML),
        assumed(),
        IMU,
        other.recording,
        other.imu,
        springs=known.springs,
    )
    assert own.springs.clock_offset == pytest.approx(unit.clock_offset, abs=1.5e-3)
    assert abs(known.springs.clock_offset - unit.clock_offset) > 3e-3
    assert np.array_equal(own.springs.stiffness, known.springs.stiffness)
    log = other.recording
    estimate = own.estimator(log.time, log.motor_angle, repaired(other.imu, IMU))
    assert path_error(estimate.displacement, other) <= path_error(rigid_path(other), other) / 5.0


def test_springs_that_leave_too_much_unexplained_are_refused_without_blaming_the_imu(first, known):
    doubtful = replace(known.springs, process_noise=0.05 * np.exp(2.0))
    log = first.recording
    with pytest.raises(ImuError, match="7 times as much unexplained as expected; identify"):
        commission(load_model(LARGE_ROBOT_XML), assumed(), IMU, log, first.imu, springs=doubtful)


def test_springs_too_soft_for_an_arm_are_no_explanation():
    """A slot whose record a mode of 1 Hz explains best, by the change of gravity sag along it."""
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
    slowest = output.known.estimator.model.arm.locked_modes()[0]
    log = run.recording
    true_arm = nominal_arm(experiment.nominal, NominalCfg(structure=True, payload=29.5))
    true = linearised(true_arm, log.motor_angle[0]).locked_modes()[0]
    assert slowest == pytest.approx(true, rel=0.15)
    assert path_error(output(run), run) < 0.2 * path_error(rigid_path(run), run)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"stiffness": 0.0}, "stiffness"),
        ({"damping": -1.0}, "damping"),
        ({"link_mass": np.nan}, "link_mass"),
    ],
)
def test_a_nominal_arm_says_what_is_out_of_range(options, said):
    with pytest.raises(ValueError, match=said):
        NominalCfg(**options)


def test_motor_angles_and_wrong_springs_alone_are_not_enough(first):
    """Negative control: what the IMU adds is needed."""
    log = first.recording
    path = relative_to_start(observe(assumed(), log.motor_angle, 0.004).tool_position[::8])
    assert path_error(path, first) > 0.4 * path_error(rigid_path(first), first)
