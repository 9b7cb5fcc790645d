"""Every parameter of an individual changes its own number of the model, and is drawn as stated."""

import copy
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from armside.sim.robot.effects import Effect, with_effects
from armside.sim.robot.individual import (
    Individual,
    structure_hinges,
    with_individual,
    with_payload,
)
from armside.sim.robot.mjcf import axis_actuators
from armside.sim.robot.spread import PRODUCTION, Spread, draw

POSE = np.deg2rad([3.5, 7.8, 12.4, 18.2, -9.2, -11.6])
AXES = range(1, 7)


@pytest.fixture(scope="module")
def design(design):
    return with_effects(design, set(Effect), phi=POSE)


def factors(seed, *shape):
    return np.exp(0.2 * np.random.default_rng(seed).standard_normal(shape))


def parameters(model):
    """Numbers of the model that an individual may change, by name, each with axes first."""
    mj = model.mj
    axes = axis_actuators(mj)
    gears = [mj.joint(f"flex_{i}").id for i in AXES]
    tendons = [mj.tendon(f"gear_{i}").id for i in AXES]
    bodies = [int(mj.jnt_bodyid[mj.joint(f"motor_{i}").id]) for i in AXES]
    hinges = structure_hinges(model)
    return {
        "coulomb": mj.actuator_biasprm[axes, 3],
        "static": mj.actuator_biasprm[axes, 4],
        "stribeck": mj.actuator_biasprm[axes, 5],
        "viscous": mj.actuator_damping[axes],
        "bristles": mj.actuator_dynprm[axes, 5],
        "bristle damping": mj.actuator_dynprm[axes, 6],
        "ripple": mj.actuator_biasprm[axes, 0],
        "soft stiffness": mj.jnt_stiffness[gears],
        "stiff part": mj.tendon_stiffness[tendons],
        "gear damping": mj.dof_damping[mj.jnt_dofadr[gears]],
        "lost motion": mj.tendon_lengthspring[tendons],
        "structure": mj.jnt_stiffness[hinges],
        "structure damping": mj.dof_damping[mj.jnt_dofadr[hinges]],
        "mass": mj.body_mass[bodies],
        "inertia": mj.body_inertia[bodies],
        "gear error": model.gear_error.amplitude,
    }


@pytest.mark.parametrize(
    ("parameter", "changed"),
    [
        ("friction", {"coulomb": 1.0, "static": 1.0}),
        ("stribeck_speed", {"stribeck": 1.0}),
        ("viscous", {"viscous": 1.0}),
        ("bristle_stiffness", {"bristles": 1.0, "bristle damping": 0.5}),
        ("ripple", {"ripple": 1.0}),
        ("gear_stiffness", {"soft stiffness": 1.0, "stiff part": 1.0, "gear damping": 0.5}),
        ("gear_damping", {"gear damping": 1.0}),
        ("lost_motion", {"lost motion": 1.0}),
        ("structure_stiffness", {"structure": 1.0, "structure damping": 0.5}),
        ("structure_damping", {"structure damping": 1.0}),
        ("mass", {"mass": 1.0, "inertia": 1.0}),
        ("gear_error", {"gear error": 1.0}),
    ],
)
def test_a_factor_multiplies_what_it_names_and_nothing_else(design, parameter, changed):
    """Powers of the factor: damping goes with the root of a stiffness, so its ratio stays."""
    factor = factors(7, 6, 4) if parameter == "gear_error" else factors(7, 6)
    before = parameters(design)
    after = parameters(with_individual(design, replace(Individual(), **{parameter: factor})))
    for name, value in before.items():
        ratio = after[name] / value
        expected = factor ** changed[name] if name in changed else np.ones(6)
        if ratio.ndim > expected.ndim:
            expected = expected[:, None]
        assert ratio == pytest.approx(np.broadcast_to(expected, ratio.shape)), name


def test_geometry_and_phases_are_added_to_those_of_the_design(design):
    rng = np.random.default_rng(1)
    individual = replace(
        Individual(),
        position=1e-3 * rng.standard_normal((6, 3)),
        orientation=1e-3 * rng.standard_normal((6, 3)),
        ripple_phase=rng.uniform(0, 6, 6),
        gear_error_phase=rng.uniform(0, 6, (6, 4)),
    )
    robot = with_individual(design, individual)
    bodies = [int(design.mj.jnt_bodyid[design.mj.joint(f"motor_{i}").id]) for i in AXES]
    moved = robot.mj.body_pos - design.mj.body_pos
    assert moved[bodies] == pytest.approx(individual.position)
    assert np.count_nonzero(np.abs(moved).sum(axis=1)) == 6
    for body, vector in zip(bodies, individual.orientation, strict=True):
        rotation = np.empty(3)
        mujoco.mju_subQuat(rotation, robot.mj.body_quat[body], design.mj.body_quat[body])
        assert rotation == pytest.approx(vector, abs=1e-12)
    axes = axis_actuators(design.mj)
    ripple = robot.mj.actuator_biasprm[axes, 2] - design.mj.actuator_biasprm[axes, 2]
    assert ripple == pytest.approx(individual.ripple_phase)
    phase = robot.gear_error.phase - design.gear_error.phase
    assert phase == pytest.approx(individual.ripple_phase[:, None] + individual.gear_error_phase)


def test_an_individual_is_the_robot_that_a_new_file_would_make(design):
    """Constants that MuJoCo derives from masses, places and angles are those of the individual."""
    individual = draw(np.random.default_rng(0), design, replace(PRODUCTION, hidden=0.0))
    for robot in (with_individual(design, individual), with_payload(design, 100.0)):
        fresh = copy.copy(robot.mj)
        mujoco.mj_setConst(fresh, mujoco.MjData(fresh))
        for name in ("body_subtreemass", "dof_M0", "dof_invweight0", "tendon_length0"):
            assert np.array_equal(getattr(robot.mj, name), getattr(fresh, name)), name
        assert not np.array_equal(robot.mj.dof_M0, design.mj.dof_M0)


# Distributions

LOG_NORMAL = {
    "friction": ("friction", 0.10),
    "gear_stiffness": ("gear_stiffness", 0.10),
    "structure_stiffness": ("structure_stiffness", 0.10),
    "friction_load": ("friction_law", 0.10),
    "static_excess": ("friction_law", 0.10),
    "stribeck_speed": ("friction_law", 0.10),
    "viscous": ("friction_law", 0.10),
    "bristle_stiffness": ("bristle_stiffness", 0.15),
    "ripple": ("ripple", 0.2),
    "lost_motion": ("lost_motion", 0.2),
    "gear_error": ("gear_error", 0.2),
    "mass": ("mass", 0.015),
    "gear_damping": ("damping", 0.2),
    "structure_damping": ("damping", 0.2),
}
"""Field of an individual: that of the spread, and its documented value in production."""


@pytest.fixture(scope="module")
def line(design):
    """A thousand robots of the production line."""
    return [draw(np.random.default_rng(seed), design, PRODUCTION) for seed in range(1000)]


@pytest.mark.parametrize("name", LOG_NORMAL)
def test_each_factor_of_a_production_line_is_log_normal_with_its_documented_spread(line, name):
    """Tolerance: five standard errors; the median robot is the design."""
    spread, expected = LOG_NORMAL[name]
    assert getattr(PRODUCTION, spread) == expected
    samples = np.log([getattr(robot, name) for robot in line])
    assert samples.std() == pytest.approx(expected, rel=5 / np.sqrt(2 * samples.size))
    assert abs(samples.mean()) < 5 * expected / np.sqrt(samples.size)


def test_geometry_and_phases_of_a_line_are_distributed_as_documented(line):
    for name in ("position", "orientation"):
        assert getattr(PRODUCTION, name) == 0.5e-3
        samples = np.array([getattr(robot, name) for robot in line])
        assert samples.std() == pytest.approx(0.5e-3, rel=5 / np.sqrt(2 * samples.size)), name
    for name in ("ripple_phase", "gear_error_phase"):
        phase = np.array([getattr(robot, name) for robot in line]).ravel()
        assert ((phase >= 0.0) & (phase < 2 * np.pi)).all()
        assert np.abs(np.exp(1j * phase).mean()) < 5 / np.sqrt(phase.size)


def test_half_of_a_production_line_has_one_to_three_hidden_hinges(line):
    count = np.array([len(robot.hidden) for robot in line])
    fraction = np.mean(count > 0)
    assert fraction == pytest.approx(0.5, abs=5 * 0.5 / np.sqrt(len(line)))
    assert set(count) == {0, 1, 2, 3}
    for robot in line:
        for hinge in robot.hidden:
            assert hinge.damping == pytest.approx(2e-4 * hinge.stiffness)
            assert 1e5 < hinge.stiffness < 1e8


def test_parameters_of_an_individual_are_drawn_independently(line):
    names = [name for name in LOG_NORMAL if name != "gear_error"]
    samples = np.array([[np.log(getattr(robot, name))[0] for name in names] for robot in line])
    correlation = np.corrcoef(samples.T)[np.triu_indices(len(names), 1)]
    assert np.abs(correlation).max() < 5 / np.sqrt(len(line))


def test_individuals_of_the_verdicts_on_chapter_9_differ_in_springs_friction_and_geometry_alone(
    design,
):
    robot, spread = draw(np.random.default_rng(3), design), Spread()
    assert (spread.friction, spread.gear_stiffness, spread.structure_stiffness) == (0.1, 0.1, 0.1)
    same = {
        *("friction_load", "static_excess", "stribeck_speed", "viscous", "bristle_stiffness"),
        *("ripple", "lost_motion", "gear_error", "mass", "gear_damping", "structure_damping"),
    }
    for name in same:
        assert (np.asarray(getattr(robot, name)) == 1.0).all(), name
    assert robot.hidden == ()
    assert not robot.gear_error_phase.any()
