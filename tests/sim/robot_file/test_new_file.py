"""Robot files made from a URDF, an MJCF, a D-H table or a template, and beside a built MJCF."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.kinematics.codegen.robot_xml import urdf
from armside.sim.robot.kinematics_check import site_poses
from armside.sim.robot.model import load_model
from armside.sim.robot_file.find import read_cell
from armside.sim.robot_file.new_file import commented, read_source, template
from armside.sim.robot_file.written import built_files, number

FOLDER = assets.LARGE_ROBOT_XML.parent
SCARA, LARGE = FOLDER / "scara.toml", FOLDER / "large_robot.toml"


def cell_of(text, folder):
    file = folder / "robot.toml"
    file.write_text(text, encoding="utf-8")
    return read_cell(file)


def same_tool(cell, model, other):
    """The two models' tools at random angles within the limits."""
    low, high = np.array(cell.limits.lower), np.array(cell.limits.upper)
    phi = np.random.default_rng(0).uniform(low, high, (5, len(low)))
    T, _ = site_poses(model, phi)
    T_other, _ = site_poses(other, phi)
    return np.allclose(T, T_other, atol=1e-9)


def test_the_template_is_a_robot_that_can_be_read(tmp_path):
    text = commented(template())
    cell = cell_of(text, tmp_path)
    assert cell.robot.n_joints == 6
    assert cell.limits.contain(np.array(cell.home))
    T, _ = site_poses(load_model(cell.xml), np.array([cell.home]))
    assert np.allclose(T[0, :3, 3], cell.poses["p1"].position, atol=1e-6)


def uncommented(line):
    """A line whose default is stated, but for keys that stand in place of others."""
    name, _, rest = line.removeprefix("# ").partition(" = ")
    other = name in ("orientation", "gamma", "delta", "cutoff")
    if name == "[[body]]" or (rest and not rest.startswith("#") and not other):
        return line.removeprefix("# ")
    return line


def test_defaults_of_a_new_file_are_those_that_are_taken(tmp_path):
    """With every # of a default taken away the file makes the same model."""
    text = commented(template())
    stated = "\n".join(map(uncommented, text.splitlines()))
    cell, other = cell_of(text, tmp_path), cell_of(stated, tmp_path)
    assert not any(taken.field.startswith("drives") for taken in other.estimates)
    mj, again = load_model(cell.xml).mj, load_model(other.xml).mj
    for name in ("body_mass", "jnt_stiffness", "dof_damping", "dof_armature"):
        assert np.allclose(getattr(mj, name), getattr(again, name), rtol=2e-3), name
    assert np.allclose(mj.actuator_gainprm, again.actuator_gainprm, rtol=2e-3)


def test_an_mjcf_of_the_project_gives_its_own_geometry_and_masses_back(tmp_path):
    cell = cell_of(commented(read_source(LARGE.with_suffix(".xml"))), tmp_path)
    model, original = load_model(cell.xml), load_model(LARGE.with_suffix(".xml"))
    assert same_tool(cell, model, original)
    moving = [original.mj.body(name).mass[0] for name in ("frame", "cylinder")]
    assert model.mj.body("link_1").mass[0] == pytest.approx(sum(moving))


@pytest.mark.parametrize("name", ["panda_like", "scara"])
def test_a_built_mjcf_is_read_as_the_robot_it_was_built_from(name, tmp_path):
    cell = read_cell(FOLDER / f"{name}.toml")
    again = cell_of(commented(read_source(cell.xml)), tmp_path)
    assert same_tool(cell, load_model(again.xml), load_model(cell.xml))
    mass, own = (load_model(one.xml).mj.body_mass for one in (again, cell))
    assert mass[2:-2] == pytest.approx(own[2:-2])


def test_a_urdf_gives_its_joints_limits_and_masses(tmp_path):
    cell = read_cell(SCARA)
    (tmp_path / "arm.urdf").write_text(urdf(cell.robot, cell.limits), encoding="utf-8")
    again = cell_of(commented(read_source(tmp_path / "arm.urdf")), tmp_path)
    assert again.limits.speed == pytest.approx(cell.limits.speed)
    assert same_tool(cell, load_model(again.xml), load_model(cell.xml))


LOOSE = """<mujoco model="loose"><compiler angle="radian"/><worldbody>
  <body name="a"><joint name="j" axis="0 1 0" ref="0.3"
  range="-1 1" limited="true"/><geom size="0.1" pos="0.3 0 0" mass="2"/>
  <body name="b" pos="0.5 0 0.1"><joint name="k" type="slide" axis="1 0 0" range="0 1"/>
  <geom size="0.05" mass="1"/></body></body></worldbody></mujoco>"""


def test_an_mjcf_of_other_names_is_read_from_the_zero_of_its_joints(tmp_path):
    file = tmp_path / "loose.xml"
    file.write_text(LOOSE, encoding="utf-8")
    source = read_source(file)
    cell = cell_of(commented(source), tmp_path)
    mj = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(mj)
    phi = np.array([0.4, 0.2])
    data.qpos[:] = phi
    mujoco.mj_kinematics(mj, data)
    T, _ = site_poses(load_model(cell.xml), phi[None])
    assert np.allclose(T[0, :3, 3], data.xpos[2], atol=1e-12)
    assert np.allclose(T[0, :3, :3], data.xmat[2].reshape(3, 3), atol=1e-12)
    assert [body.mass for body in source.hardware.bodies] == [2.0, 1.0]
    assert cell.limits.lower[0] == -1.0


def test_a_tip_that_is_not_in_the_file_and_a_file_of_another_kind_are_refused(tmp_path):
    file = tmp_path / "loose.xml"
    file.write_text(LOOSE, encoding="utf-8")
    with pytest.raises(ValueError, match=r"^loose\.xml: .*link 'e' is not in the file"):
        read_source(file, "e")
    with pytest.raises(ValueError, match="source must be a"):
        read_source(Path("robot.step"))


def test_built_files_are_a_robot_of_the_same_cell(tmp_path):
    cell = read_cell(SCARA)
    for name, text in built_files(cell, "arm").items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    again = read_cell(tmp_path / "arm.toml")
    assert again.xml == tmp_path / "arm.xml"
    assert replace(again, xml=cell.xml, estimates=cell.estimates) == cell


def test_programs_and_the_imu_go_with_a_built_robot(tmp_path):
    files = built_files(read_cell(LARGE), "large")
    assert "programs/large_simultaneous.toml" in files
    (tmp_path / "programs").mkdir()
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    cell, again = read_cell(LARGE), read_cell(tmp_path / "large.toml")
    assert again.with_imu == cell.with_imu
    assert again.poses == cell.poses


def test_fractions_of_pi_are_written_as_text():
    given = -np.pi / 2, 3 * np.pi / 4, np.pi, 0.5, -0.0
    assert [str(number(value)) for value in given] == ["-pi/2", "3*pi/4", "pi", "0.5", "0"]
