"""What is known of a robot that is found by name or file."""

import pytest

from armside.kinematics import Body, Link, Robot
from armside.kinematics.codegen.robot_xml import urdf
from armside.sim.robot_file.find import load_robot

ARM = Robot([Link(a=0.4, alpha="Pi/2"), Link(a=0.3)])
BODY = Body(mass=2.0, com=(-0.1, 0, 0), inertia=(0.01, 0.02, 0.02, 0, 0, 0))


@pytest.mark.parametrize("bodies", [(), (BODY, BODY)])
def test_an_arm_whose_file_has_no_masses_says_so(tmp_path, bodies):
    file = tmp_path / "arm.urdf"
    file.write_text(urdf(ARM, bodies=bodies))
    found = load_robot(str(file))
    assert sum(body.mass for body in found.bodies) == 2.0 * len(bodies)
    assert [note[:24] for note in found.notes] == ["The source has no masses"] * (not bodies)
