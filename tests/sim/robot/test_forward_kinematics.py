"""An MJCF whose geometry is not that of the D-H table is refused, with the place."""

import mujoco
import numpy as np
import pytest

from armside.sim.cell import CELLS
from armside.sim.laser import Cut, prepare
from armside.sim.robot.forward_kinematics import (
    POSITION,
    check_kinematics,
    configurations,
    differences,
)
from armside.sim.robot.mjcf import ModelError
from armside.sim.robot.model import load_model


@pytest.fixture
def altered(tmp_path):
    """The large robot's file with one body moved [m] or rotated."""

    def write(body, offset=(0.0, 0.0, 0.0), quaternion=None):
        spec = mujoco.MjSpec.from_file(str(CELLS["large"].xml))
        changed = spec.body(body)
        changed.pos = np.array(changed.pos) + offset
        if quaternion is not None:
            changed.quat = quaternion
        spec.compile()
        file = tmp_path / "other.xml"
        file.write_text(spec.to_xml())
        return file

    return write


@pytest.mark.parametrize("name", CELLS)
def test_the_robots_of_the_project_have_the_kinematics_of_their_tables(name):
    cell = CELLS[name]
    model = load_model(cell.xml)
    position, rotation = differences(model, cell.robot, configurations(cell.limits))
    assert position.max() < 1e-6
    assert rotation.max() < 1e-6
    check_kinematics(model, cell.robot, cell.limits)


def test_configurations_lie_within_the_limits_and_contain_the_zero_pose():
    limits = CELLS["irb1400"].limits
    phi = configurations(limits)
    assert not phi[0].any()
    assert len(phi) > 20
    assert limits.contain(phi[1:]).all()


def wrist(name="large"):
    """Body behind motor 5."""
    model = load_model(CELLS[name].xml).mj
    return model.body(int(model.jnt_bodyid[model.joint("motor_5").id])).name


def test_a_shorter_forearm_is_refused_with_its_difference_and_place(altered):
    """The finding: the forearm is 100 mm shorter, and the hole would be 98 mm off."""
    body = load_model(CELLS["large"].xml).mj
    file = altered(body.body(int(body.jnt_bodyid[body.joint("motor_4").id])).name, (-0.1, 0, 0))
    with pytest.raises(
        ModelError, match=r"other\.xml.* 100 mm and 0.000 deg off .* motor angles \("
    ):
        prepare(Cut(model=file))


def test_a_tilted_tool_is_refused_though_it_is_in_its_place(altered):
    half = np.deg2rad(0.5)
    with pytest.raises(ModelError, match=r"mm and 1.000 deg off"):
        prepare(Cut(model=altered(wrist(), quaternion=(np.cos(half), np.sin(half), 0.0, 0.0))))


def test_a_difference_below_what_a_program_resolves_is_accepted(altered):
    file = altered(wrist(), (0.2 * POSITION, 0.0, 0.0))
    assert prepare(Cut(model=file)).motion.reached_speed == 0.040


def test_the_model_of_the_other_robot_is_refused():
    with pytest.raises(ModelError, match="off the D-H model"):
        prepare(Cut(robot="irb1400", model=CELLS["large"].xml))
