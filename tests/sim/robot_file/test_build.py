"""Hardware that a robot file states, and the MJCF that is built from it."""

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.kinematics import Convention, Joint, Limits, Link, Robot
from armside.kinematics.rotation import from_axis_angle
from armside.sim.robot.kinematics_check import site_poses
from armside.sim.robot.model import load_model
from armside.sim.robot_file.body_frames import frames, points
from armside.sim.robot_file.build import build
from armside.sim.robot_file.find import read_cell
from armside.sim.robot_file.hardware import Hardware, LinkBody, StructureHinge

FOLDER = assets.LARGE_ROBOT_XML.parent
SHIPPED = ("ur5e_like", "panda_like", "scara", "kr16_like", "m16ib_like")
ROUNDED = 1e-3
"""Relative: estimates have four digits."""


def model_of(robot, limits, hardware=Hardware(), **more):
    text = build(robot, limits, hardware, **more).text
    return load_model(mujoco.MjModel.from_xml_string(text))


def limits_of(n):
    return Limits(lower=(-2.0,) * n, upper=(2.0,) * n, speed=(2.0,) * n)


def pose(robot, phi):
    """Base to tool (4, 4) by the elementary motions of each row."""
    T, variables = np.eye(4), iter(robot.joint_variables(phi))
    for link in robot.links:
        q = next(variables) if link.moves else 0.0
        theta = float(link.theta) + (q if link.joint is Joint.REVOLUTE else 0.0)
        d = float(link.d) + (q if link.joint is Joint.PRISMATIC else 0.0)
        along_z, along_x = screw(theta, d, 2), screw(float(link.alpha), float(link.a), 0)
        standard = robot.convention is Convention.STANDARD
        T = T @ (along_z @ along_x if standard else along_x @ along_z)
    return T


def screw(angle, length, axis):
    T = np.eye(4)
    T[:3, :3] = from_axis_angle(np.eye(3)[axis], angle)
    T[axis, 3] = length
    return T


@pytest.mark.parametrize("name", SHIPPED)
def test_a_robot_file_without_an_mjcf_makes_the_model_of_its_table(name):
    cell = read_cell(FOLDER / f"{name}.toml")
    T, _ = site_poses(load_model(cell.xml), np.array([cell.home]))
    assert np.allclose(T[0], pose(cell.robot, np.array(cell.home)), atol=1e-12)
    assert cell.estimates
    again = read_cell(FOLDER / f"{name}.toml")
    assert again.xml == cell.xml
    assert again.estimates == cell.estimates


@pytest.mark.parametrize("convention", Convention)
def test_any_table_of_one_to_nine_axes_is_the_chain_of_the_model(convention):
    rng = np.random.default_rng(3)
    for n in range(1, 10):
        kinds = [Joint.PRISMATIC if slides else Joint.REVOLUTE for slides in rng.random(n) < 0.2]
        links = [Link(*rng.uniform(-1, 1, 4).tolist(), joint=kind) for kind in kinds]
        links.insert(rng.integers(n + 1), Link(0.3, 0.2, 0.1, -0.4, Joint.FIXED))
        signs = np.diag(rng.choice([-1.0, 1.0], n))
        robot = Robot(links, signs, rng.uniform(-1, 1, n), convention)
        phi = rng.uniform(-1, 1, (5, n))
        T, _ = site_poses(model_of(robot, limits_of(n)), phi)
        assert np.allclose(T, [pose(robot, one) for one in phi], atol=1e-12)


def test_points_of_the_chain_are_origins_of_the_joints():
    robot = Robot([Link(d=1.0, a=0.6), Link(a=0.5)])
    assert np.allclose(points(frames(robot)), [[0, 0, 0], [0.6, 0, 1.0], [1.1, 0, 1.0]])


def test_the_imu_stands_where_its_links_lead():
    robot = Robot([Link(d=1.0, a=0.6), Link(a=0.5)])
    imu = [Link(theta=0.4, d=0.1, a=0.05, alpha=1.0, joint=Joint.FIXED)]
    with_imu = Robot([*robot.links, *imu], name="with IMU")
    model = model_of(robot, limits_of(2), with_imu=with_imu)
    phi = np.array([0.3, -0.5])
    T, _ = site_poses(model, phi[None], "imu")
    assert np.allclose(T[0], pose(with_imu, phi), atol=1e-12)


def test_motors_that_move_several_joints_are_refused():
    robot = Robot([Link(a=0.6), Link(a=0.5)], coupling=[[1, 0], [-1, 1]])
    with pytest.raises(ValueError, match="coupling must be diagonal with 1 or -1"):
        build(robot, limits_of(2), Hardware())


def test_what_is_given_is_what_the_model_has():
    """An arm in a plane, whose inertias are the textbook's."""
    robot = Robot([Link(a=0.6), Link(a=0.5)])
    bar = [(12.0, 0.6), (6.0, 0.5)]
    bodies = tuple(
        LinkBody(
            mass=m, centre=(-a / 2, 0, 0), inertia=(0.01, m * a**2 / 12, m * a**2 / 12, 0, 0, 0)
        )
        for m, a in bar
    )
    hardware = Hardware(
        bodies=bodies,
        tool=LinkBody(mass=3.0, centre=(0, 0, 0), inertia=(0.01, 0.01, 0.01, 0, 0, 0)),
        drives={
            "gear_ratio": (100.0, 80.0),
            "rotor_inertia": (2e-4, 1e-4),
            "torque_limit": (300.0, 120.0),
            "bandwidth": (5.0, 6.0),
            "coulomb_friction": (10.0, 4.0),
            "viscous_friction": (3.0, 2.0),
        },
        gears={"frequency": (9.0, 20.0), "damping_ratio": (0.02, 0.04)},
    )
    model = model_of(robot, limits_of(2), hardware)
    inertia = np.array([12 * 0.36 / 3 + 6 * (1.1**3 - 0.6**3) / 0.5 / 3 + 3 * 1.21, 6 * 0.25 / 3])
    inertia[1] += 3 * 0.25
    inertia += np.array([0.01, 0.01])  # tool
    armature = np.array([2.0, 0.64])
    assert np.allclose(model.mj.dof_armature[model.motor], armature)
    stiffness = (2 * np.pi * np.array([9.0, 20.0])) ** 2 * inertia
    assert np.allclose(
        model.mj.jnt_stiffness[model.mj.dof_jntid[model.flex]], stiffness, rtol=ROUNDED
    )
    damping = 2 * np.array([0.02, 0.04]) * np.sqrt(stiffness * inertia)
    assert np.allclose(model.mj.dof_damping[model.flex], damping, rtol=ROUNDED)
    drives, n = model.drives, np.array([100.0, 80.0])
    omega = 2 * np.pi * np.array([5.0, 6.0])
    assert np.allclose(drives.kp * n**2, (inertia + armature) * omega**2, rtol=ROUNDED)
    assert np.allclose(drives.kd * n**2, 2.3 * (inertia + armature) * omega, rtol=ROUNDED)
    assert np.allclose(drives.torque_limit * n, [300, 120])
    assert np.allclose(drives.coulomb_friction * n, [10, 4])
    assert np.allclose(drives.static_friction * n, [11.4, 4.56])
    assert np.allclose(drives.viscous_friction * n**2, [3, 2])


def hinge(name, **more):
    kind = {"direction": (0, 1, 0), "stiffness": 1e5, "damping_ratio": 0.01}
    return StructureHinge(name=name, **kind, **more)


def test_a_structure_hinge_moves_the_tool_about_its_line():
    robot = Robot([Link(d=1.0, a=0.6), Link(a=0.5)])
    hinges = (
        hinge("tilt", link=0, point=(0, 0, 0), damping=None),
        hinge("bend", link=1, point=(-0.6, 0, 0), damping=20.0),
    )
    mj = model_of(robot, limits_of(2), Hardware(structure=hinges)).mj
    data = mujoco.MjData(mj)
    for name, lever in (("tilt", [1.0, 0.0, -1.1]), ("bend", [0.0, 0.0, -1.1])):
        mujoco.mj_forward(mj, data)
        jacobian = np.empty((3, mj.nv))
        mujoco.mj_jacSite(mj, data, jacobian, None, mj.site("tool0").id)
        dof = int(mj.joint(f"struct_{name}").dofadr[0])
        assert np.allclose(jacobian[:, dof], lever, atol=1e-12)
    assert mj.joint("struct_bend").damping[0] == 20.0


def test_masses_without_a_word_are_estimated_and_said_so():
    robot = Robot([Link(d=0.5, alpha=np.pi / 2), Link(a=1.0), Link(a=1.0)])
    built = build(robot, limits_of(3), Hardware())
    said = {taken.field: taken for taken in built.taken}
    assert said["hardware: mass"].values == pytest.approx((320.0,))
    assert said["hardware: mass"].rule.startswith("ESTIMATE")
    moving = sum(said["body: mass"].values)
    assert said["base: mass"].values[0] + moving == pytest.approx(320.0, rel=ROUNDED)
    mj = mujoco.MjModel.from_xml_string(built.text)
    whole = mj.body_mass.sum() - mj.body("tool").mass[0]
    assert whole == pytest.approx(320.0, rel=ROUNDED)


def test_masses_beyond_that_of_the_robot_are_refused():
    robot, one = Robot([Link(a=0.6), Link(a=0.5)]), LinkBody(mass=12.0)
    with pytest.raises(ValueError, match="mass must exceed that of base and links, got 14 kg"):
        build(robot, limits_of(2), Hardware(mass=14.0, bodies=(one, LinkBody())))


def test_plain_mujoco_loads_and_draws_a_built_robot():
    cell = read_cell(FOLDER / "scara.toml")
    mj = mujoco.MjModel.from_xml_path(str(cell.xml))
    drawn = mj.geom_bodyid[(mj.geom_group == 2) & (mj.geom_rgba[:, 3] > 0)]
    assert {mj.body(body).name for body in drawn} >= {"base", "link_1", "link_2", "tool"}
