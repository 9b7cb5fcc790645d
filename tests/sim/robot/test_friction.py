"""Friction of the drives over speed, load and temperature, against the curve of its source."""

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.sim.robot.effects import Effect, load_friction, with_effects
from armside.sim.robot.individual import draw, structure_hinges, with_friction, with_individual
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


def test_a_drive_under_load_has_the_friction_of_its_robot():
    """Every axis: holding torque over peak torque, then the robot's own scale and static part."""
    design = load_model(assets.LARGE_ROBOT_XML)
    model = with_effects(design, {Effect.LOAD_FRICTION}, phi=POSE)
    drives, numeric = design.drives, design.mj.numeric
    hold = Statics(design).equilibrium(POSE).holding_torque
    load = hold / (drives.gear * drives.torque_limit)
    assert np.ptp(np.abs(load)) > 0.05  # axes are loaded differently
    coulomb, stribeck, viscous, speed = published(load, numeric("gear_temperature").data[0])
    scale = numeric("load_friction_scale").data * drives.torque_limit
    static = coulomb + numeric("load_friction_static").data[0] * stribeck
    for i in range(6):
        axis = model.mj.actuator(f"axis_{i + 1}").id
        assert model.mj.actuator_biasprm[axis, 3:6] == pytest.approx(
            [scale[i] * coulomb[i], scale[i] * static[i], speed]
        )
        assert model.mj.actuator_damping[axis] == pytest.approx(viscous * drives.torque_limit[i])


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
    axes = [mj.actuator(f"axis_{i}").id for i in range(1, 7)]
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


def test_factors_of_friction_scale_what_load_friction_set():
    model = with_effects(load_model(assets.LARGE_ROBOT_XML), {Effect.LOAD_FRICTION}, phi=POSE)
    factor = np.linspace(0.7, 1.3, 6)
    before, after = (m.mj.actuator_biasprm for m in (model, with_friction(model, factor)))
    assert after[:, 3:5] == pytest.approx(before[:, 3:5] * factor[:, None])
    assert after[:, 5] == pytest.approx(before[:, 5])


def test_an_individual_has_its_own_friction_and_stiffness_on_every_axis():
    model = load_model(assets.LARGE_ROBOT_XML)
    individual = draw(np.random.default_rng(4), len(structure_hinges(model)))
    robot = with_individual(model, individual)
    for i in range(6):
        axis, flex = model.mj.actuator(f"axis_{i + 1}").id, model.mj.joint(f"flex_{i + 1}").id
        ratio = robot.mj.actuator_biasprm[axis, 3:5] / model.mj.actuator_biasprm[axis, 3:5]
        assert ratio == pytest.approx([individual.friction[i]] * 2)
        stiffer = robot.mj.jnt_stiffness[flex] / model.mj.jnt_stiffness[flex]
        assert stiffer == pytest.approx(individual.gear_stiffness[i])
    hinges = structure_hinges(model)
    ratio = robot.mj.jnt_stiffness[hinges] / model.mj.jnt_stiffness[hinges]
    assert ratio == pytest.approx(individual.structure_stiffness)
    moved = robot.mj.body_pos - model.mj.body_pos
    bodies = [model.mj.jnt_bodyid[model.mj.joint(f"motor_{i}").id] for i in range(1, 7)]
    assert moved[bodies] == pytest.approx(individual.position)
    assert np.count_nonzero(np.abs(moved).sum(axis=1)) == 6


def test_the_documented_spreads_are_the_defaults_and_every_draw_has_its_own():
    """10 % on friction and springs, 0.5 mm and 0.5 mrad on geometry, phases uniform."""
    robots = [draw(np.random.default_rng(seed), 6) for seed in range(1000)]
    n = 6 * len(robots)
    for name, expected in (("friction", 0.10), ("gear_stiffness", 0.10)):
        values = np.log([getattr(robot, name) for robot in robots])
        assert values.std() == pytest.approx(expected, rel=5 / np.sqrt(2 * n)), name
        assert abs(values.mean()) < 5 * expected / np.sqrt(n)
    structure = np.log([robot.structure_stiffness for robot in robots])
    assert structure.std() == pytest.approx(0.10, rel=5 / np.sqrt(2 * n))
    for name in ("position", "orientation"):
        values = np.array([getattr(robot, name) for robot in robots])
        assert values.std() == pytest.approx(0.5e-3, rel=5 / np.sqrt(6 * n)), name
    phase = np.array([robot.ripple_phase for robot in robots]).ravel()
    assert ((phase >= 0.0) & (phase < 2 * np.pi)).all()
    assert np.abs(np.exp(1j * phase).mean()) < 5 / np.sqrt(n)
    together = np.array([[r.friction[0], r.gear_stiffness[0], r.position[0, 0]] for r in robots])
    correlation = np.corrcoef(together.T)[np.triu_indices(3, 1)]
    assert np.abs(correlation).max() < 5 / np.sqrt(len(robots))
