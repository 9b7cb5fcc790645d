"""Individuals by their number: the same robot on any day, on any design, with what each one has."""

import pickle
from dataclasses import fields, replace

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh

from armside.sim.laser import Cut, prepare
from armside.sim.laser.loop import first_run
from armside.sim.robot.effects import available
from armside.sim.robot.individual import (
    HiddenHinge,
    Individual,
    as_built,
    embodied,
    with_hinges,
    with_individual,
)
from armside.sim.robot.linkage import Linkage, loop_error
from armside.sim.robot.mjcf import ModelError, mass_matrix
from armside.sim.robot.spread import Drawn, check_applies, inapplicable
from armside.sim.robot.statics import Statics
from armside.sim.robot.virtual_robot import VirtualRobot

GRAVITY = 9.82  # [m/s^2], of the models
HINGE = HiddenHinge(body="tube", axis=(0, 1, 0), stiffness=2e6, damping=400.0)
WITH_HINGES = 6  # Number of an individual with hidden hinges


def values(individual):
    names = [field.name for field in fields(individual) if field.name != "hidden"]
    return [np.asarray(getattr(individual, name)) for name in names]


def test_equal_numbers_are_equal_robots_to_the_last_bit(design):
    first, again, other = (Drawn(n).of(design) for n in (WITH_HINGES, WITH_HINGES, 2))
    assert all(np.array_equal(a, b) for a, b in zip(values(first), values(again), strict=True))
    assert first.hidden == again.hidden
    assert first.hidden
    assert not np.array_equal(first.friction, other.friction)


def test_the_seed_changes_noise_and_instruments_but_not_the_individual(design):
    cut = Cut(individual=Drawn(WITH_HINGES), without=())
    a, b = (prepare(cut, seed=seed, nominal=design) for seed in (0, 1))
    for name in ("jnt_stiffness", "body_mass", "body_pos", "actuator_biasprm"):
        assert np.array_equal(getattr(a.loaded.model.mj, name), getattr(b.loaded.model.mj, name))
    one, other = (first_run(e).recording.truth.tool_position for e in (a, b))
    assert not np.array_equal(one, other)


def test_a_design_has_the_parameters_of_its_file_and_draws_do_not_depend_on_them(design, irb1400):
    assert not inapplicable(design)
    lacking = inapplicable(irb1400)
    assert {"lost_motion", "gear_error", "ripple", "ripple_phase", "static_excess"} <= set(lacking)
    large, small = (Drawn(WITH_HINGES).of(model) for model in (design, irb1400))
    for field in fields(Individual):
        drawn = getattr(small, field.name)
        if field.name in lacking:
            assert np.array_equal(drawn, getattr(Individual(), field.name)), field.name
        elif field.name not in ("hidden", "structure_damping"):
            assert np.array_equal(drawn, getattr(large, field.name)), field.name


@pytest.mark.parametrize("name", ["lost_motion", "ripple", "friction_load", "gear_error"])
def test_a_parameter_that_a_design_lacks_is_refused_by_name(irb1400, name):
    individual = replace(Individual(), **{name: 1.1 * getattr(Individual(), name)})
    with pytest.raises(ModelError, match=f"^{name} does not apply to a robot without"):
        prepare(Cut(robot="irb1400", individual=individual), nominal=irb1400)


@pytest.mark.parametrize(
    ("name", "n", "said"),
    [
        ("structure_stiffness", 4, "structure_stiffness must be one factor or 6, .* got 4"),
        ("mass", 5, "mass must be one number or 6, one for each axis, got 5"),
    ],
)
def test_values_for_another_number_of_axes_or_hinges_are_refused(design, name, n, said):
    with pytest.raises(ModelError, match=said):
        check_applies(design, Individual(**{name: np.ones(n)}))


@pytest.mark.parametrize("number", range(4))
def test_individuals_of_the_irb1400_keep_their_linkage_closed(irb1400, number):
    made = prepare(Cut(robot="irb1400", individual=Drawn(number)), nominal=irb1400)
    truth = first_run(made).recording.truth
    assert loop_error(made.loaded.model.mj, truth.qpos[::8]) < 1e-7


@pytest.mark.parametrize(
    ("kind", "given", "said"),
    [
        (Individual(), {"mass": np.full(6, np.nan)}, "mass must be 6 finite numbers, got"),
        (Individual(), {"structure_damping": np.ones((2, 3))}, "damping must be one number or one"),
        (HINGE, {"stiffness": 0.0}, "stiffness must be > 0 N m/rad, got 0"),
        (HINGE, {"damping": -1.0}, "damping must be >= 0 N m s/rad, got -1"),
        (HINGE, {"body": ""}, "body must be the name of a body"),
    ],
)
def test_parameters_of_a_wrong_shape_or_size_are_refused(kind, given, said):
    with pytest.raises(ValueError, match=said):
        replace(kind, **given)


def test_a_hinge_needs_a_body_of_its_robot_and_an_axis_of_its_own(design):
    with pytest.raises(ModelError, match=r"needs a body, got 'tail'. Bodies: base, frame,"):
        with_hinges(design, [replace(HINGE, body="tail")])
    for body, axis in (("tube", (-2, 0, 0)), ("elbow", (0, 1, 0)), ("lower_arm", (0, 0, 1))):
        with pytest.raises(ModelError, match=f"lies on the axis of .* of the body {body}"):
            with_hinges(design, [replace(HINGE, body=body, axis=axis)])
    with pytest.raises(ModelError, match="lies on the axis of hidden_0"):
        with_hinges(design, [HINGE, HINGE])


# What a hidden hinge does


def test_a_hidden_hinge_yields_by_its_load_over_its_stiffness(design):
    """Load of gravity about the hinge at rest; springs before it tilt its axis by 1e-4 rad."""
    model = with_hinges(design, [HINGE])
    rest = Statics(model).equilibrium(np.zeros(6))
    dof = int(model.mj.joint("hidden_0").dofadr[0])
    data = mujoco.MjData(model.mj)
    data.qpos[:] = rest.qpos
    mujoco.mj_forward(model.mj, data)
    about = data.xanchor[model.mj.joint("hidden_0").id]
    carried = [model.mj.body(name).id for name in ("tube", "tilt", "disc", "tool")]
    lever = sum(model.mj.body_mass[b] * (data.xipos[b] - about)[0] for b in carried)
    assert rest.qpos[dof] == pytest.approx(GRAVITY * lever / HINGE.stiffness, rel=1e-6)


def test_a_hidden_hinge_adds_lever_squared_over_stiffness_to_the_compliance(design):
    """At the tool, by the weight of 10 kg more; deflections of one part in a thousand of a radian
    change levers by as much."""
    force = 10.0 * GRAVITY

    def sag(hinges):
        individual = Individual(hidden=tuple(hinges))
        heights = []
        for payload in (40.0, 50.0):
            args = {"phi": np.zeros(6), "payload": payload}
            model = embodied(design, individual, (), **args)
            data = mujoco.MjData(model.mj)
            data.qpos[:] = Statics(model).equilibrium(np.zeros(6)).qpos
            mujoco.mj_kinematics(model.mj, data)
            heights.append(data.xipos[model.mj.body("tool").id][2])
        return heights[0] - heights[1]

    lever = 1.142 + 0.2 + 0.25
    more = sag([HINGE]) - sag([])
    assert more == pytest.approx(force * lever**2 / HINGE.stiffness, rel=5e-3)


def test_a_hidden_hinge_lowers_every_mode_and_adds_one(design, reference):
    """Rayleigh: the modes without the hinge lie between those with it."""

    def modes(model):
        M = mass_matrix(model.mj, model.posture @ reference[0])
        springs = model.springs
        K = np.diag(model.mj.jnt_stiffness[model.mj.dof_jntid[springs]])
        return np.sqrt(eigh(K, M[np.ix_(springs, springs)], eigvals_only=True))

    before, after = modes(design), modes(with_hinges(design, [HINGE]))
    assert len(after) == len(before) + 1
    slack = 1e-9 * before
    assert (after[:-1] <= before + slack).all()
    assert (before <= after[1:] + slack).all()
    assert after[0] < 0.999 * before[0]


def test_hinges_of_the_lists_lie_apart_from_every_other_axis(design, irb1400):
    """No inertia matrix is singular: no pair of hinges turns the same bodies about one axis."""
    for model in (design, irb1400):
        for number in range(12):
            mj = with_hinges(model, Drawn(number).of(model).hidden).mj
            assert np.linalg.cond(mass_matrix(mj, mj.qpos0)) < 1e7


# What other parameters do


def test_more_viscous_friction_is_torque_in_proportion_to_speed(design, reference):
    """Drive torque of two robots that follow the same reference, against the motor's speed."""
    double = with_individual(design, replace(Individual(), viscous=np.full(6, 2.0)))
    runs = [VirtualRobot(m).load(reference).run() for m in (design, double)]
    speed = np.gradient(runs[0].motor_angle, runs[0].time, axis=0) * design.drives.gear
    more = runs[1].motor_torque - runs[0].motor_torque
    for axis in range(3):
        slope, _ = np.polyfit(speed[:, axis], more[:, axis], 1)
        assert slope == pytest.approx(design.drives.viscous_friction[axis], rel=0.1)
        assert np.corrcoef(speed[:, axis], more[:, axis])[0, 1] > 0.9


def test_a_heavier_link_weighs_on_the_motors_before_it_by_its_own_weight(design):
    """Link 3, stretched forward: elbow with its tube's bearing, 190 kg at -0.05 m of axis 3."""
    heavier = with_individual(design, replace(Individual(), mass=np.array([1, 1, 1.1, 1, 1, 1])))
    held = [
        Statics(m).motor_torque(Statics(m).rigid_forces(*np.zeros((3, 1, 6))))[0]
        for m in (design, heavier)
    ]
    more = held[1] - held[0]
    assert abs(more[2]) == pytest.approx(19.0 * GRAVITY * 0.05, rel=1e-9)
    assert more[1] == pytest.approx(more[2], rel=1e-9)  # the elbow is straight above axis 2
    assert more[[0, 3, 4, 5]] == pytest.approx(0.0, abs=1e-9)


def test_the_mass_of_a_link_is_all_that_its_motor_carries_but_the_tool(design, irb1400):
    for model, axis, bodies in (
        (design, 1, {"frame", "cylinder"}),
        (design, 6, {"disc"}),
        (irb1400, 2, {"lower_arm", "lever", "upper_arm"}),
        (irb1400, 3, {"crank", "rod"}),
    ):
        mass = np.ones(6)
        mass[axis - 1] = 1.5
        heavier = with_individual(model, replace(Individual(), mass=mass)).mj
        changed = np.flatnonzero(heavier.body_mass != model.mj.body_mass)
        assert {model.mj.body(int(i)).name for i in changed} == bodies


# Individuals on their way


def test_an_individual_with_hidden_hinges_runs_alike_in_another_process(design):
    """A model loses its parsed file when it is sent; a run needs none."""
    loaded = prepare(Cut(individual=Drawn(WITH_HINGES)), nominal=design).loaded
    sent = pickle.loads(pickle.dumps(loaded))
    assert sent.model.mj.nq > design.mj.nq
    assert np.array_equal(sent.run().truth.qpos, loaded.run().truth.qpos)


def test_a_robot_as_built_has_the_numbers_of_its_individual_in_its_file(design):
    individual = Drawn(WITH_HINGES).of(design)
    built = as_built(design, individual)
    mj = built.parsed().compile()
    same = with_individual(with_hinges(design, individual.hidden), individual).mj
    for name in ("jnt_stiffness", "dof_damping", "body_pos", "body_quat", "body_mass"):
        assert getattr(mj, name) == pytest.approx(getattr(same, name), rel=1e-14, abs=1e-15), name
    assert mj.actuator_biasprm == pytest.approx(same.actuator_biasprm, rel=1e-14)
    assert available(built) == available(design)


def test_drift_scales_the_friction_of_a_run_and_not_the_individual(design):
    cut = Cut(individual=Drawn(2))
    worn = prepare(replace(cut, friction_drift=0.1), nominal=design)
    fresh = prepare(cut, nominal=design)
    before, after = (e.loaded.model.mj.actuator_biasprm for e in (fresh, worn))
    assert after[:, 3:5] == pytest.approx(1.1 * before[:, 3:5], rel=1e-12)
    assert np.array_equal(worn.individual.friction, fresh.individual.friction)


def test_a_warm_gear_has_less_viscous_friction_and_another_stribeck_speed(design):
    """The published law at 50 against 33 deg C: exp(-T / 20.71), and -24.81 + 0.98 T."""
    cold, warm = (prepare(Cut(temperature=t), nominal=design).loaded.model.mj for t in (33, 50))
    expected = [1.3e-4 + 1.32e-3 * np.exp(-t / 20.71) for t in (33, 50)]
    ratio = warm.actuator_damping / cold.actuator_damping
    assert ratio == pytest.approx(np.full(6, expected[1] / expected[0]))
    assert (warm.actuator_biasprm[:, 5] == -24.81 + 0.98 * 50).all()
    with pytest.raises(ValueError, match="temperature must be from 26 to 80 deg C, got 20"):
        prepare(Cut(temperature=20.0), nominal=design)


def test_temperature_without_friction_that_depends_on_it_is_refused(irb1400):
    with pytest.raises(ValueError, match="temperature needs friction that depends on load"):
        prepare(Cut(robot="irb1400", temperature=50.0), nominal=irb1400)


def test_linkages_decide_whether_structure_damping_is_drawn(design, irb1400):
    assert Linkage(design.mj).is_open
    assert np.ptp(Drawn(0).of(design).structure_damping) > 0.0
    assert Drawn(0).of(irb1400).structure_damping == 1.0


@pytest.mark.parametrize("number", [6, 11])
def test_the_axis_of_a_hidden_hinge_is_of_unit_length_and_leans_by_at_most_15_degrees(
    design, number
):
    free = {"lower_arm": 2, "tube": 0, "tilt": 1}
    hinges = Drawn(number).of(design).hidden
    assert {hinge.body for hinge in hinges} == set(free)
    for hinge in hinges:
        assert np.linalg.norm(hinge.axis) == pytest.approx(1.0)
        assert abs(hinge.axis[free[hinge.body]]) <= np.sin(np.deg2rad(15.0)) + 1e-12
