"""Friction of the drives over speed, load and temperature, against the curve of its source."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.sim.robot.drives import friction_torque
from armside.sim.robot.effects import Effect, FrictionFactors, load_friction, with_effects
from armside.sim.robot.mjcf import axis_actuators
from armside.sim.robot.model import load_model
from armside.sim.robot.statics import Statics

POSE = np.deg2rad([3.5, 7.8, 12.4, 18.2, -9.2, -11.6])
XML = {"large": assets.LARGE_ROBOT_XML, "irb1400": assets.IRB1400_XML}


def published(load, temperature):
    """Bittencourt's model of an ABB axis, relative to its peak torque: terms of the source."""
    load = np.abs(load)
    coulomb = 0.0311 + 0.0234 * load
    stribeck = 0.126 * load + (-0.025 + 0.0016 * temperature)
    viscous = 1.3e-4 + 1.32e-3 * np.exp(-temperature / 20.71)
    return coulomb, stribeck, viscous, -24.81 + 0.98 * temperature


@pytest.mark.parametrize("temperature", [25.0, 33.0, 50.0, 80.0])
@pytest.mark.parametrize("load", [0.0, 0.2, -0.7, 1.0])
def test_friction_depends_on_load_and_temperature_as_published(load, temperature):
    coulomb, static, viscous, speed = load_friction(np.array([load]), temperature)
    fc, fs, fv, vs = published(load, temperature)
    assert (coulomb[0], static[0], viscous, speed) == pytest.approx((fc, fc + fs, fv, vs))


@pytest.mark.parametrize("temperature", [None, 50.0])
def test_a_drive_under_load_has_the_friction_of_its_robot(design, temperature):
    """Every axis: holding torque over peak torque, then the robot's own scale and static part."""
    own = FrictionFactors(*np.exp(np.random.default_rng(0).normal(0.0, 0.1, (3, 6))))
    hold = Statics(design).equilibrium(POSE).holding_torque
    drives, numeric = design.drives, design.mj.numeric
    load = np.abs(hold / (drives.gear * drives.torque_limit))
    assert np.ptp(load) > 0.05  # axes are loaded differently
    warm = 33.0 if temperature is None else temperature
    for factors in (FrictionFactors(), own):
        model = with_effects(
            design, {Effect.LOAD_FRICTION}, phi=POSE, friction=factors, temperature=temperature
        )
        _, stribeck, viscous, speed = published(load, warm)
        coulomb = 0.0311 * factors.constant + 0.0234 * load * factors.load
        excess = numeric("load_friction_static").data[0] * stribeck * factors.static_excess
        scale = numeric("load_friction_scale").data * drives.torque_limit
        axes, speeds = axis_actuators(model.mj), np.full(6, speed)
        expected = np.column_stack([scale * coulomb, scale * (coulomb + excess), speeds])
        assert model.mj.actuator_biasprm[axes, 3:6] == pytest.approx(expected)
        assert model.mj.actuator_damping[axes] == pytest.approx(viscous * drives.torque_limit)


@pytest.mark.parametrize(
    ("name", "effects"),
    [("large", ()), ("large", (Effect.LOAD_FRICTION,)), ("irb1400", ())],
)
def test_a_drive_at_constant_speed_feels_its_friction_curve(name, effects):
    """Each motor is pulled at a speed until its bristles slide: F_c + (F_s - F_c) exp(-(v/v_s)^2).

    Viscous friction is a damping force of the joint, n^2 times that of the motor.
    """
    model = with_effects(load_model(XML[name]), effects, phi=POSE)
    mj, gear = model.mj, model.drives.gear
    axes = axis_actuators(mj)
    sensors = [mj.sensor(f"axis_{i}_torque").adr[0] for i in range(1, 7)]
    coulomb, static, stribeck = mj.actuator_biasprm[axes, 3:6].T
    for speed in (1.0, -4.0, 12.0, 40.0):  # motor side, below and above the Stribeck speed
        data = mujoco.MjData(mj)
        # the set point is what is driven, so the servo adds nothing to friction
        data.ctrl.reshape(6, 3)[:, 1] = speed
        for _ in range(round(3.0 / abs(speed) ** 0.5 / mj.opt.timestep)):
            data.qpos[:], data.qvel[:] = 0.0, 0.0
            data.qvel[model.motor] = speed / gear
            mujoco.mj_step(mj, data)
        data.qpos[:], data.qvel[:] = 0.0, 0.0
        data.qvel[model.motor] = speed / gear
        mujoco.mj_forward(mj, data)
        sliding = coulomb + (static - coulomb) * np.exp(-((speed / stribeck) ** 2))
        assert data.sensordata[sensors] == pytest.approx(-np.sign(speed) * sliding, rel=0.01)
        damper = data.qfrc_damper[model.motor] / gear
        assert damper == pytest.approx(-mj.actuator_damping[axes] * speed, rel=1e-6)


def test_friction_feedforward_fades_to_zero_below_its_speed(irb1400):
    """0.7 of Coulomb friction times tanh(v / 0.02 rad/s), arm side, whatever the gear."""
    drives = replace(irb1400.drives, friction_curve=False)
    speed = np.repeat([[0.002], [0.02], [0.05], [0.5], [2.0]], 6, axis=1)
    full = 0.7 * drives.coulomb_friction * drives.gear
    assert friction_torque(drives, speed) == pytest.approx(np.tanh(speed / 0.02) * full)
