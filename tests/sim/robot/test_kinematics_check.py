"""An MJCF whose geometry is not that of the D-H table is refused, with place and axis."""

import time
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from armside import kinematics
from armside.sim.cell import CELLS
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.individual import with_payload
from armside.sim.robot.kinematics_check import (
    ROTATION,
    between,
    cell_model,
    check_kinematics,
    configurations,
    first_axis,
    site_poses,
)
from armside.sim.robot.mjcf import ModelError
from armside.sim.robot.model import load_model, robot_model

LARGE, IRB1400 = CELLS["large"], CELLS["irb1400"]


def check(model, cell=LARGE):
    check_kinematics(model, cell.robot, cell.limits, cell.with_imu)


def parsed(cell=LARGE):
    return mujoco.MjSpec.from_file(str(cell.xml))


def moved(spec, element, *offset):
    """The file with a body or a site moved in its parent by `offset` [m]."""
    element.pos = np.add(element.pos, offset)
    return spec


def moved_body(name, *offset):
    return moved(spec := parsed(), spec.body(name), *offset)


def moved_site(name, *offset):
    return moved(spec := parsed(), spec.site(name), *offset)


def refusal(spec, cell=LARGE):
    with pytest.raises(ModelError) as caught:
        check(robot_model(spec), cell)
    return str(caught.value)


@pytest.mark.parametrize("name", CELLS)
def test_the_robots_of_the_project_agree_to_rounding(name):
    cell = CELLS[name]
    model, phi = load_model(cell.xml), configurations(cell.limits)
    for robot, site in ((cell.robot, "tool0"), (cell.with_imu, "imu")):
        T = site_poses(model, phi, site)[0]
        position, rotation = between(T, kinematics.compile(robot).pose(np.ascontiguousarray(phi)))
        assert position.max() < 1e-12
        assert rotation.max() < 1e-12
    assert site_poses(model, phi)[1].max() < 1e-12
    assert first_axis(model, cell.robot) is None


def test_configurations_lie_within_the_limits_and_contain_the_zero_pose():
    phi = configurations(IRB1400.limits)
    assert not phi[0].any()
    assert len(phi) > 20
    assert IRB1400.limits.contain(phi[1:]).all()


def test_a_shorter_forearm_is_refused_with_difference_place_and_axis():
    """Motor 4 turns about the forearm: the first axis that is in another place is 5."""
    said = refusal(moved_body("tilt", -0.1, 0.0, 0.0))
    assert "is no LARGE_ROBOT: its tool is 100 mm and 0 deg off the D-H model at motor" in said
    assert said.endswith("deg; axis 5 is the first that moves it otherwise")


def test_an_axis_that_turns_the_other_way_is_refused_by_its_number():
    spec = parsed()
    for name in ("motor_3", "flex_3"):
        spec.joint(name).axis = -np.array(spec.joint(name).axis)
    assert refusal(spec).endswith("axis 3 is the first that moves it otherwise")


def test_a_wholly_different_arm_is_refused():
    assert "axis 2 is the first" in refusal(moved_body("lower_arm", 0.4, 0.1, -0.2))
    with pytest.raises(ModelError, match=r"is no IRB1400: its tool is \d+"):
        cell_model(IRB1400, LARGE.xml)


@pytest.mark.parametrize(("site", "words"), [("tool0", "its tool"), ("imu", "the site imu")])
def test_a_site_that_is_moved_by_2_mm_is_refused_though_every_axis_agrees(site, words):
    said = refusal(moved_site(site, 0.0, 0.0, 0.002))
    assert f"{words} is 2 mm and 0 deg off" in said
    assert said.endswith("every axis agrees, it is mounted elsewhere")


def test_a_tool_that_is_rotated_where_it_stands_is_refused():
    spec, half = parsed(), np.deg2rad(0.5)
    rotation = np.array([np.cos(half), np.sin(half), 0.0, 0.0])
    turned, own = np.zeros(4), np.array(spec.site("tool0").quat)
    mujoco.mju_mulQuat(turned, own, rotation)
    spec.site("tool0").quat = turned
    assert "0 mm and 1 deg off" in refusal(spec)


@pytest.mark.parametrize("distance", [0.5e-6, 2e-6])
def test_half_a_micrometre_passes_and_two_do_not(distance):
    spec = moved_site("tool0", distance, 0.0, 0.0)
    if distance > 1e-6:
        refusal(spec)
    else:
        check(robot_model(spec))


def test_a_right_angle_of_five_digits_is_beyond_the_tolerance_of_rotation():
    spec, half = parsed(), 0.5 * (1.5708 - 0.5 * np.pi)
    assert 2.0 * half > ROTATION
    spec.site("imu").quat = np.array([np.cos(half), np.sin(half), 0.0, 0.0])
    assert "the site imu is 0 mm and 0.0002105 deg off" in refusal(spec)


def test_a_closed_chain_with_a_longer_rod_is_refused():
    """The tree below the tool is that of the table; its cut is open by the excess of the rod."""
    spec = parsed(IRB1400)
    cut = next(each for each in spec.equalities if each.type == mujoco.mjtEq.mjEQ_CONNECT)
    longer = moved(spec, spec.site(cut.name2), 0.005, 0.0, 0.0)
    assert "the closed chain of the model is open by 5 mm" in refusal(longer, IRB1400)


@pytest.mark.parametrize(
    ("cell", "flexibility"),
    [(LARGE, Flexibility.GEARS), *((IRB1400, each) for each in Flexibility)],
)
def test_springs_hinges_of_the_structure_and_payload_do_not_disturb_it(cell, flexibility):
    check(load_model(variant(cell.xml, flexibility, gear_stiffness=0.2)), cell)
    check(with_payload(load_model(LARGE.xml), 80.0))


def test_a_table_with_another_number_of_axes_is_refused():
    short = kinematics.Robot(LARGE.robot.links[:5], name="FIVE_AXES")
    with pytest.raises(ModelError, match="the model has 6 axes, the D-H model FIVE_AXES 5"):
        check(load_model(LARGE.xml), replace(LARGE, robot=short))


@pytest.mark.parametrize("name", CELLS)
def test_it_is_cheap_enough_to_run_always(name):
    """A third of the 15 ms here: 2 ms are usual, on a core that other tests use too."""
    cell = CELLS[name]
    model, seconds = load_model(cell.xml), []
    for _ in range(10):
        start = time.process_time()
        check(model, cell)
        seconds.append(time.process_time() - start)
    assert min(seconds) < 0.015
