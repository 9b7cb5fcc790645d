"""The observed arm and its linear form beside the rollout."""

from dataclasses import replace

import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.ilc.filters import butterworth, recursion
from armside.sim.estimation.arm_filter import arm_filter
from armside.sim.estimation.arm_identification import prepared, with_nonlinear_residual
from armside.sim.estimation.imu_health import repaired
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.observer import dragged, observe
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.laser import prepare
from armside.sim.laser.learning import first_run
from armside.sim.laser.path_error import path_error, rigid_path
from armside.sim.motion.timing import PathLimits
from armside.sim.robot.model import load_model

from .one_cut import CUT, IMU, assumed, spread


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
    assert made.imu is not None
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
