"""Arms of MJCF files: pose, masses and limits beside MuJoCo, and refusals by name."""

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.kinematics import InertialModel, compile_dynamics
from armside.kinematics.rigid import link_frames
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot.mjcf import mass_matrix
from armside.sim.robot.model import RobotModel, robot_model
from armside.sim.robot_file.find import find_cell, load_robot
from armside.sim.robot_file.mjcf_reader import read_mjcf, serial_bodies

ROUNDING = 1e-10
ARM = """<mujoco model="lab arm"><compiler angle="degree" autolimits="true"/><worldbody>
<body name="base" pos="0.1 0.2 0.3" euler="10 20 30">
  <inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>
  <body name="shoulder" pos="0 0 0.4" euler="0 90 5">
    <inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.2 0.2"/>
    <joint name="turn" axis="0 1 2" pos="0.02 -0.03 0.01" range="-90 45" ref="20"/>
    <joint name="tilt" axis="1 0 0" pos="0.05 0 0"/>
    <joint name="flex_1" axis="0 0 1" stiffness="100"/>
    <body name="slider" pos="0.3 0 0" euler="40 0 0">
      <inertial pos="0 0 0.1" euler="0 30 0" mass="1" diaginertia="0.02 0.02 0.03"/>
      <joint name="slide" type="slide" axis="1 0 1" range="-0.2 0.5" ref="0.1"/>
      <site name="eye" pos="0 0.1 0"/>
      <body name="hand" pos="0 0 0.2" euler="0 0 70"><geom size="0.05" mass="0.5"/>
        <site name="tool0" pos="0.1 0 0" euler="0 45 0"/></body>
    </body></body></body></worldbody></mujoco>"""


def written(folder: Path, text: str) -> Path:
    file = folder / "arm.xml"
    file.write_text(text)
    return file


def test_any_chain_of_hinges_and_slides_has_mujocos_pose(tmp_path):
    file = written(tmp_path, ARM)
    arm = read_mjcf(file)
    assert arm.joints == ("turn", "tilt", "slide")
    np.testing.assert_allclose(arm.limits.lower, [-np.pi / 2, -2 * np.pi, -0.2])
    np.testing.assert_allclose(arm.limits.upper, [np.pi / 4, 2 * np.pi, 0.5])
    mj = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(mj)
    for q in np.random.default_rng(0).uniform(-1, 1, (5, 3)):
        for name, value in zip(arm.joints, q, strict=True):
            data.joint(name).qpos[:] = value
        mujoco.mj_kinematics(mj, data)
        T = link_frames(arm.robot, q)[-1]
        np.testing.assert_allclose(T[:3, 3], data.site("tool0").xpos, rtol=0, atol=ROUNDING)
        R = data.site("tool0").xmat.reshape(3, 3)
        np.testing.assert_allclose(T[:3, :3], R, rtol=0, atol=ROUNDING)


def test_bodies_have_mujocos_masses_and_centres(tmp_path):
    arm = read_mjcf(written(tmp_path, ARM))
    assert arm.bodies is not None
    mj = mujoco.MjModel.from_xml_string(ARM)
    data, q = mujoco.MjData(mj), np.array([0.4, -0.3, 0.2])
    for name, value in zip(arm.joints, q, strict=True):
        data.joint(name).qpos[:] = value
    mujoco.mj_kinematics(mj, data)
    mujoco.mj_comPos(mj, data)
    expected = data.body("shoulder").subtree_com
    frames = link_frames(arm.robot, q)
    weighed = [(float(b.mass), F) for b, F in zip(arm.bodies, frames, strict=True)]
    places = [F @ [*map(float, b.com), 1.0] for b, F in zip(arm.bodies, frames, strict=True)]
    total = sum(mass for mass, _ in weighed)
    assert total == pytest.approx(3.5)
    com = np.sum([m * p for (m, _), p in zip(weighed, places, strict=True)], axis=0) / total
    np.testing.assert_allclose(com[:3], expected, rtol=0, atol=ROUNDING)


def test_a_chain_is_chosen_by_base_and_tip(tmp_path):
    file = written(tmp_path, ARM)
    assert read_mjcf(file, "base", "shoulder").joints == ("turn", "tilt")
    named = load_robot(f"{file}#shoulder:eye").arm
    assert named.robot.n_joints == 1
    text = re.sub(r'<site name="tool0"[^>]*>', '<site name="flange"/>', ARM)
    with pytest.raises(ValueError, match=r"several branches; choose a tip .*: eye, flange"):
        read_mjcf(written(tmp_path, text))


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('type="slide" axis="1 0 1" range="-0.2 0.5" ref="0.1"', 'type="ball"', "'slide' is ball"),
        (' range="-0.2 0.5"', "", "joint 'slide': a slide needs a range"),
        ("</worldbody>", "", "XML"),
        (
            "</mujoco>",
            '<equality><joint joint1="tilt" joint2="turn"/></equality></mujoco>',
            "joint 'tilt' mimics 'turn'; joints must be independent",
        ),
        (
            "</mujoco>",
            '<equality><connect name="rod" body1="hand" body2="base" anchor="0 0 0"/></equality>'
            "</mujoco>",
            r"joint 'turn' is part of a closed chain \(rod\)",
        ),
    ],
)
def test_what_no_serial_arm_has_is_refused_by_name(old, new, complaint, tmp_path):
    assert old in ARM
    with pytest.raises(ValueError, match=rf"^arm\.xml: .*{complaint}") as caught:
        read_mjcf(written(tmp_path, ARM.replace(old, new)))
    assert "\n" not in str(caught.value)


def test_a_parallelogram_is_refused_by_its_rod():
    with pytest.raises(ValueError, match=r"'motor_2' is part of a closed chain \(rod_to_lever\)"):
        read_mjcf(assets.IRB1400_XML)


TWO_LINK = str(Path(assets.LARGE_ROBOT_XML).with_name("two_link.toml"))


def without_rotors(model: RobotModel, phi: np.ndarray) -> np.ndarray:
    """Mass matrix of the motor angles with springs at rest, less the rotors'."""
    D = mass_matrix(model.mj, model.posture @ phi)
    return model.posture.T @ (D - np.diag(model.mj.dof_armature)) @ model.posture


@pytest.mark.parametrize("name", ["large", TWO_LINK], ids=["large", "two-link"])
def test_the_mass_matrix_is_that_of_the_hardware_at_rest(name):
    cell = find_cell(name)
    model = cell_model(cell)
    found = serial_bodies(model, cell.robot)
    assert found.left_out == ()
    dynamics = compile_dynamics(InertialModel(cell.robot, found.bodies))
    for phi in np.random.default_rng(0).uniform(-1, 1, (3, cell.robot.n_joints)):
        expected = without_rotors(model, phi)
        np.testing.assert_allclose(dynamics.mass_matrix(phi), expected, rtol=1e-10, atol=1e-10)


def test_the_linkage_of_the_irb1400_is_left_out_by_name():
    """Its crank and rod made light, the rest is the mass matrix of the hardware."""
    cell = find_cell("irb1400")
    model = cell_model(cell)
    found = serial_bodies(model, cell.robot)
    assert set(found.left_out) == {"crank", "rod"}
    assert any("crank" in note for note in load_robot("irb1400", masses=True).notes)
    spec = model.parsed()
    for name in found.left_out:
        body = spec.body(name)
        body.mass, body.inertia = 1e-9, np.full(3, 1e-9)
    phi = np.array([0.3, -0.2, 0.4, 0.5, -0.6, 0.7])
    expected = without_rotors(robot_model(spec), phi)
    dynamics = compile_dynamics(InertialModel(cell.robot, found.bodies))
    np.testing.assert_allclose(dynamics.mass_matrix(phi), expected, rtol=0, atol=1e-7)
