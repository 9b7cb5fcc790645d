"""Inputs of the servo, noise, reported torque and limits of a run, each against its own formula.

One motion of each robot is loaded once; what enters the servo is compared with what should.
"""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.signal import lfilter

from armside import assets
from armside.sim.robot.drives import friction_torque
from armside.sim.robot.effects import Effect, with_effects
from armside.sim.robot.mjcf import axis_actuators
from armside.sim.robot.model import load_model
from armside.sim.robot.run import WATCHED
from armside.sim.robot.servo import correction_path, interpolate
from armside.sim.robot.statics import Statics
from armside.sim.robot.virtual_robot import VirtualRobot

PERIOD = 0.004
START = np.array([0.3, 0.2, -0.1, 0.4, 0.7, -0.5])
XML = {"large": assets.LARGE_ROBOT_XML, "irb1400": assets.IRB1400_XML}


def motion(n=250, size=0.05):
    """(n, 6) [rad]: all axes there and back, at rest at both ends."""
    turn = np.sin(np.pi * np.linspace(0.0, 1.0, n)) ** 2
    return START + size * turn[:, None] * np.array([1.0, -0.6, 0.8, 1.2, -1.0, 1.5])


@pytest.fixture(scope="module", params=XML)
def loaded(request):
    return VirtualRobot(load_model(XML[request.param])).load(motion())


@pytest.fixture(scope="module")
def correction():
    t = np.linspace(0.0, 1.0, 250)[:, None]
    return 2e-3 * np.sin(2 * np.pi * (2 + np.arange(6)) * t) * np.sin(np.pi * t) ** 2


def split(controls):
    """Position [motor rad], velocity [motor rad/s] and torque [motor N m], each (M, 6)."""
    return np.moveaxis(controls.reshape(len(controls), 6, 3), 2, 0)


def shifted(signal, model):
    """One step earlier where feedback acts on the velocity at the end of a step."""
    return np.vstack((signal[1:], signal[-1:])) if model.implicit else signal


# Set points


def test_the_servo_gets_the_reference_its_rate_and_the_rigid_torque(loaded):
    model, drives = loaded.model, loaded.model.drives
    position, velocity, torque = split(loaded.controls)
    r, r_dot, _ = interpolate(loaded.reference, PERIOD, 8)
    assert position / drives.gear == pytest.approx(r, abs=1e-12)
    fed = drives.velocity_feedforward * shifted(r_dot, model)
    assert velocity / drives.gear == pytest.approx(fed, abs=1e-9)
    # torque: rigid inverse dynamics and friction, from the holding torque of the flexible arm on
    statics = Statics(model)
    _, phi_dot, phi_ddot = interpolate(loaded.reference, PERIOD, 1)
    rigid = statics.motor_torque(statics.rigid_forces(loaded.reference, phi_dot, phi_ddot))
    rigid, _, _ = interpolate(rigid, PERIOD, 8)
    if drives.friction_feedforward:
        rigid = rigid + friction_torque(drives, r_dot)
    hold = statics.equilibrium(START).holding_torque
    assert torque * drives.gear == pytest.approx(rigid - rigid[0] + hold, abs=1e-6)


def test_a_correction_moves_position_and_velocity_set_points_alike(loaded, correction):
    model, drives = loaded.model, loaded.model.drives
    with_u, noise = loaded.controls_with(correction, None)
    assert noise is None
    more = split(with_u - loaded.controls)
    path = correction_path(correction, PERIOD, 8, drives.correction_delay, drives.correction_lag)
    assert more[0] == pytest.approx(drives.gear * path.position, abs=1e-9)
    fed = drives.velocity_feedforward * shifted(path.velocity, model)
    assert more[1] == pytest.approx(drives.gear * fed, abs=1e-9)
    assert not more[2].any()


def test_a_transmission_error_enters_position_and_velocity_consistently():
    """The rate of what is added to the position is what is added to the velocity."""
    plain = load_model(assets.LARGE_ROBOT_XML)
    rough = with_effects(plain, {Effect.GEAR_ERROR}, phi=START)
    exact, erring = (VirtualRobot(model).load(motion()).controls for model in (plain, rough))
    position, velocity, _ = split(erring - exact) / plain.drives.gear[None, :]
    step = plain.timestep
    central = (position[2:] - position[:-2]) / (2 * step)
    # the velocity of a step is that of its end: row i belongs to time (i + 1) h
    assert velocity[:-2] == pytest.approx(central, abs=2e-3 * np.abs(central).max())
    phi = interpolate(motion(), PERIOD, 8)[0]
    amplitude, phase = (plain.mj.numeric(name).data for name in ("gear_error", "gear_error_phase"))
    phase = phase.reshape(6, 4)
    for axis, gear in enumerate(plain.drives.gear):
        order = np.array([1.0, 2.0, gear, 2.0 * gear])
        expected = np.sin(order * phi[:, axis, None] + phase[axis]) @ amplitude
        assert position[:, axis] == pytest.approx(expected, abs=1e-12)


# Noise


def test_torque_noise_has_its_size_and_bandwidth_and_changes_torque_alone(loaded):
    model = replace(loaded.model, drives=replace(loaded.model.drives, encoder_noise=0.0))
    quiet = replace(loaded, model=model)
    zero, drives = np.zeros_like(loaded.reference), model.drives
    draws = [
        split(quiet.controls_with(zero, np.random.default_rng(seed))[0] - loaded.controls)
        for seed in range(40)
    ]
    assert not np.any([draw[:2] for draw in draws])
    torque = np.array([draw[2] for draw in draws]) / drives.torque_limit
    c = np.exp(-2 * np.pi * drives.torque_noise_bandwidth * model.timestep)
    # independent samples of an autoregression: n (1 - c^2) / (1 + c^2); five standard errors
    n = torque.size * (1 - c**2) / (1 + c**2)
    assert torque.std() == pytest.approx(drives.torque_noise, rel=5 / np.sqrt(2 * n))
    per_axis = torque.std(axis=(0, 1)) / drives.torque_noise
    assert per_axis == pytest.approx(np.ones(6), rel=5 / np.sqrt(2 * n / 6))
    lag_1 = np.mean(torque[:, 1:] * torque[:, :-1]) / torque.var()
    assert 1 - lag_1 == pytest.approx(1 - c, rel=0.1)


def test_encoder_noise_reaches_position_speed_and_log_with_one_sign():
    """The servo compares set points with q + n: (pos - n) - q, and so does the speed loop."""
    model = load_model(assets.IRB1400_XML)
    drives = replace(model.drives, torque_noise=0.0)
    noisy = VirtualRobot(replace(model, drives=drives)).load(motion())
    zero = np.zeros_like(noisy.reference)
    controls, n = noisy.controls_with(zero, np.random.default_rng(0))
    position, velocity, torque = split(controls - noisy.controls)
    one_count = 2 * np.pi / drives.encoder_counts
    assert n.std() == pytest.approx(0.3 * one_count, rel=5 / np.sqrt(2 * n.size))
    assert position == pytest.approx(-n, abs=1e-12)
    c = np.exp(-2 * np.pi * 200.0 * model.timestep)  # low-pass of a difference quotient
    difference = np.diff(n, axis=0, prepend=np.zeros((1, 6))) / model.timestep
    speed = lfilter([1 - c], [1, -c], difference, axis=0)
    assert velocity == pytest.approx(-speed, rel=1e-9, abs=1e-9)
    assert not torque.any()
    run = noisy.run(None, np.random.default_rng(0))
    read = (run.motor_angle - run.truth.motor_angle[::8]) * drives.gear
    assert np.abs(read - n[::8]).max() <= 0.5 * one_count * (1 + 1e-6)


def test_the_noise_of_the_servo_stops_while_the_brakes_hold():
    model = load_model(assets.IRB1400_XML)
    still = np.tile(START, (250, 1))
    noisy = VirtualRobot(model).load(still, motors_on_at=0.5)
    controls, _ = noisy.controls_with(np.zeros_like(still), np.random.default_rng(0))
    added = split(controls - noisy.controls)
    off = np.arange(len(controls)) * model.timestep < 0.5
    assert not added[:, off].any()
    assert (added[:, ~off].std(axis=1) > 0.0).all()
    assert not split(noisy.controls)[2][off].any()


# Reported torque


def test_the_reported_torque_is_that_of_the_physics_integral_included():
    """Without friction the actuators' own force sensors show it, through saturation too."""
    mj = mujoco.MjModel.from_xml_path(str(assets.IRB1400_XML))
    mj.actuator_biasprm[:, 3:5] = 1e-12  # LuGre: Coulomb and static friction, and its damping
    mj.actuator_dynprm[:, 6] = 0.0
    mj.actuator_damping[:] = 0.0
    model = load_model(mj)
    model = replace(model, drives=replace(model.drives, torque_feedforward=0.3))
    kick = 0.08 * np.sin(np.pi * np.linspace(0.0, 1.0, 250)) ** 40
    loaded = VirtualRobot(model).load(motion(size=0.3))
    run = loaded.run(kick[:, None] * np.ones(6))
    controls, _ = loaded.controls_with(run.correction, None)
    data = mujoco.MjData(mj)
    mujoco.mj_setState(mj, data, loaded.initial_state, int(mujoco.mjtState.mjSTATE_FULLPHYSICS))
    sensors = [mj.sensor(f"axis_{i}_torque").adr[0] for i in range(1, 7)]
    measured = np.empty_like(run.truth.motor_torque)
    for i, row in enumerate(controls):
        data.ctrl[:] = row
        mujoco.mj_step(mj, data)
        measured[i] = data.sensordata[sensors]
    assert run.truth.motor_torque == pytest.approx(measured, abs=1e-9)
    limit = model.drives.torque_limit
    assert (np.abs(measured).max(axis=0) >= limit).any()  # some axis saturates
    assert (np.abs(measured).max(axis=0) < limit).any()
    assert run.motor_torque == pytest.approx(measured[::8], abs=1e-9)


def test_the_controllers_gains_are_those_of_the_physics(loaded):
    mj, drives = loaded.model.mj, loaded.model.drives
    axes = axis_actuators(mj)
    gains = np.column_stack([drives.kp, drives.ki, drives.kd])
    assert mj.actuator_gainprm[axes, 4:7] == pytest.approx(gains)
    limits = np.column_stack([-drives.torque_limit, drives.torque_limit])
    assert mj.actuator_forcerange[axes] == pytest.approx(limits)


# Limits


def watched(run, model):
    """|torque|, |speed|, and the joint angle of each axis, (M, 6)."""
    truth = run.truth
    speed = np.gradient(truth.gear_angle, model.timestep, axis=0)
    return np.abs(truth.motor_torque), np.abs(speed), truth.gear_angle


def with_limits(loaded, factor, axes=slice(None)):
    """The run's limits of some axes moved to `factor` of what it does."""
    model, drives = loaded.model, loaded.model.drives
    torque, speed, angle = watched(loaded.run(), model)
    low, high = angle.min(axis=0), angle.max(axis=0)
    out = (factor - 1.0) * (high - low)
    torques, speeds = drives.torque_limit.copy(), drives.speed_limit.copy()
    ranges = model.joint_range.copy()
    torques[axes] = factor * torque.max(axis=0)[axes]
    speeds[axes] = factor * speed.max(axis=0)[axes]
    ranges[axes] = np.column_stack((low - out, high + out))[axes]
    moved = replace(drives, torque_limit=torques, speed_limit=speeds)
    return replace(loaded, model=replace(model, drives=moved, joint_range=ranges))


def test_each_limit_is_noticed_where_it_is_reached_and_not_before(loaded):
    """Limits are moved to just inside and just outside what the run does: by 2 %."""
    assert loaded.run().limits_hit == ()
    assert with_limits(loaded, 1.02).run().limits_hit == ()
    for axis in range(6):
        hits = with_limits(loaded, 0.98, axis).run().limits_hit
        assert [hit[:2] for hit in hits] == [(name, axis + 1) for name in WATCHED]
        assert all(0.0 <= time < loaded.reference.shape[0] * PERIOD for _, _, time in hits)


def test_the_instant_of_a_limit_is_the_first_beyond_it(loaded):
    model, drives = loaded.model, loaded.model.drives
    run = loaded.run()
    speed = np.abs(run.truth.gear_angle[1:] - run.truth.gear_angle[:-1])[:, 3] / model.timestep
    limit = np.where(np.arange(6) == 3, 0.7 * speed.max(), drives.speed_limit)
    slow = replace(loaded, model=replace(model, drives=replace(drives, speed_limit=limit)))
    ((_, _, time),) = slow.run().limits_hit
    expected = run.truth.time[np.flatnonzero(speed >= limit[3])[0]]
    assert time == pytest.approx(expected, abs=2 * model.timestep)


@pytest.mark.parametrize("axis", [1, 2, 4])
def test_a_load_is_refused_exactly_where_a_drive_cannot_hold_it(design, axis):
    model = design
    hold = np.abs(Statics(model).equilibrium(START).holding_torque) / model.drives.gear
    still = np.tile(START, (10, 1))

    def load(factor):
        limit = np.where(np.arange(6) == axis, factor * hold[axis], model.drives.torque_limit)
        VirtualRobot(replace(model, drives=replace(model.drives, torque_limit=limit))).load(still)

    load(1.01)
    with pytest.raises(ValueError, match=f"at rest axis {axis + 1} would have to hold"):
        load(0.99)
