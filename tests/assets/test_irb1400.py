"""The IRB1400 of assets/irb1400.xml: its data and its closed chain.

Reference values: thesis Table 4.2, Figure 4.1 and section 5.1.1; the linkage forces were found with
an independent prototype of the same data.
"""

import mujoco
import numpy as np
import pytest

from armside import assets, kinematics
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.linkage import Linkage, checked_loop_error, loop_error
from armside.sim.robot.mjcf import AXES
from armside.sim.robot.model import load_model
from armside.sim.robot.virtual_robot import VirtualRobot

from .irb1400_motion import at_rest_pose, brisk_motion, held, through

DH_TOLERANCE = 0.5e-6  # [m], rigid closed chain against D-H: the solver's compliance
LOOP_TOLERANCE = 1e-6  # [m], the cut of the parallelogram in any run
ROUNDING = 1e-14  # [m]


@pytest.fixture(scope="module")
def dh():
    return kinematics.compile(kinematics.IRB1400)


# Data


def test_the_scene_holds_the_robot_and_its_cameras():
    scene = mujoco.MjModel.from_xml_path(str(assets.IRB1400_XML.with_name("irb1400_scene.xml")))
    assert load_model(scene).mj.ncam == 3


def test_both_robots_expose_the_same_interface(full):
    large = load_model(assets.LARGE_ROBOT_XML)
    assert set(full.sensors) == set(large.sensors)
    for site in ("tool0", "imu", "tracker_target"):
        assert full.mj.site(site).id >= 0
    for i in AXES:
        assert full.mj.actuator(f"axis_{i}").trnid[0] == full.mj.joint(f"motor_{i}").id
    assert full.mj.key("zero").qpos == pytest.approx(np.zeros(full.mj.nq))


def test_the_wrist_reaches_1_44_m_within_the_limits_of_the_axes(full):
    p2, p3 = np.radians(70.0), np.arctan2(0.12, 0.72)
    wrist = at_rest_pose(full, np.array([0.0, p2, p3, 0.0, 0.0, 0.0])).body("tilt").xpos
    assert wrist[0] == pytest.approx(1.44, abs=0.005)


def test_the_zero_pose_is_that_of_the_thesis(full):
    data = at_rest_pose(full, np.zeros(6))
    assert data.site("tool0").xpos == pytest.approx([0.955, 0.0, 1.195], abs=ROUNDING)
    rotation = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    assert data.site("tool0").xmat.reshape(3, 3) == pytest.approx(np.array(rotation), abs=1e-15)
    assert data.site("imu").xpos == pytest.approx([0.987, -0.026, 1.285], abs=ROUNDING)
    assert data.site("imu").xmat.reshape(3, 3) == pytest.approx(np.eye(3), abs=1e-15)


def test_each_centre_of_mass_lies_in_its_link(full):
    mj = full.mj
    for body in range(1, mj.nbody):
        drawn = body
        while not mj.body_geomnum[drawn]:  # lumped masses lie in the link that carries them
            drawn = mj.body_parentid[drawn]
        corners = []
        for geom in range(mj.body_geomadr[drawn], mj.body_geomadr[drawn] + mj.body_geomnum[drawn]):
            rotation = np.empty(9)
            mujoco.mju_quat2Mat(rotation, mj.geom_quat[geom])
            centre, half = mj.geom_aabb[geom, :3], mj.geom_aabb[geom, 3:]
            box = centre + half * np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
            corners.append(mj.geom_pos[geom] + box @ rotation.reshape(3, 3).T)
        corners = np.concatenate(corners)
        com = mj.body_ipos[body]
        name = mj.body(body).name
        assert (corners.min(axis=0) <= com).all(), name
        assert (com <= corners.max(axis=0)).all(), name


def test_its_shapes_neither_collide_nor_weigh(full):
    assert not full.mj.geom_contype.any()
    assert not full.mj.geom_conaffinity.any()


def test_servo_gains_follow_from_the_inertia_of_the_zero_pose(full):
    """kp n^2 = J w0^2 with 9 and 25 Hz, kd n^2 = 2 * 0.8 J w0, ki = 4 kp."""
    data, mass = at_rest_pose(full, np.zeros(6)), np.zeros((full.mj.nv, full.mj.nv))
    mujoco.mj_fullM(full.mj, data, mass)
    J = np.diag(full.posture.T @ mass @ full.posture)
    w0, n2 = 2.0 * np.pi * np.array([9, 9, 9, 25, 25, 25]), full.drives.gear**2
    assert full.drives.kp * n2 == pytest.approx(J * w0**2, rel=2e-3)
    assert full.drives.kd * n2 == pytest.approx(1.6 * J * w0, rel=2e-3)
    assert full.drives.ki == pytest.approx(4.0 * full.drives.kp)


def test_friction_is_as_small_against_the_servo_as_on_the_large_robot(full):
    """How far Coulomb friction deflects a motor before the proportional part overcomes it."""
    large = load_model(assets.LARGE_ROBOT_XML).drives
    deflection, of_large = (d.coulomb_friction / d.kp for d in (full.drives, large))
    assert 0.8 * of_large.min() < deflection.min()
    assert deflection.max() < of_large.max()


# The closed chain


def test_the_passive_joints_follow_the_motors_in_every_pose(full, dh):
    """The constant map closes the loop exactly, and puts the tool where D-H with (4.10) says."""
    rng = np.random.default_rng(1)
    limits, linkage = kinematics.IRB1400_LIMITS, Linkage(full.mj)
    phi = rng.uniform(limits.lower, limits.upper, (150, 6))
    for row in phi[limits.contain(phi)]:
        data = at_rest_pose(full, row)
        assert np.abs(linkage.gap(data)).max() < ROUNDING
        assert data.site("tool0").xpos == pytest.approx(dh.pose(row)[:3, 3], abs=ROUNDING)


def test_the_constant_map_is_what_the_constraint_itself_implies(rigid):
    """Tangent of the cut, from the Jacobians of its two sites, in an arbitrary pose."""
    data = at_rest_pose(rigid, np.array([0.3, 0.6, -0.2, 0.1, 0.2, 0.3]))
    follow = Linkage(rigid.mj).tangent(data)
    assert follow[:, rigid.motor] == pytest.approx(rigid.posture, abs=1e-13)


def test_the_rigid_closed_chain_moves_as_d_h_with_the_coupling_says(rigid, dh):
    """To the corners of |phi_2| <= 70, |phi_3 - phi_2| <= 70, -65 <= phi_3 <= 70 deg."""
    corners = [(0, 0), (70, 70), (70, 0), (5, -65), (-70, -65), (-70, 0), (0, 70), (0, 0)]
    corners = np.radians(corners)
    waypoints = np.zeros((len(corners), 6))
    waypoints[:, 1:3] = corners
    waypoints[:, 0] = np.radians([0, 40, -30, 20, 0, -40, 10, 0])
    waypoints[:, 3:] = np.radians(30) * np.array([1, -1, 2])
    run = VirtualRobot(rigid).run(through(waypoints, 1.0), rng=np.random.default_rng(0))
    truth = run.truth
    assert np.ptp(truth.motor_angle, axis=0)[1:3] == pytest.approx(np.radians([140, 135]), abs=0.02)
    expected = dh.pose(truth.motor_angle)[:, :3, 3]
    assert np.linalg.norm(truth.tool_position - expected, axis=1).max() < DH_TOLERANCE
    assert loop_error(rigid.mj, truth.qpos[::20]) < LOOP_TOLERANCE


def test_the_loop_stays_closed_with_flexible_joints_and_noise(full):
    run = VirtualRobot(full).run(brisk_motion(), rng=np.random.default_rng(0))
    assert loop_error(full.mj, run.truth.qpos[::10]) < LOOP_TOLERANCE


def test_a_run_whose_loop_opened_is_refused(full):
    qpos = np.zeros((2, full.mj.nq))
    assert checked_loop_error(full.mj, qpos) < 1e-12
    qpos[1, full.mj.joint("link_elbow").qposadr] = 1e-4  # 16 um at the lever's pin
    with pytest.raises(RuntimeError, match="opened by 16 um, more than 1 um"):
        checked_loop_error(full.mj, qpos)


def test_flexible_joints_move_the_tool_away_from_d_h_and_stiff_gears_bring_it_back(dh):
    """Distance between motor-angle D-H and the tool: proportional to the gears' compliance."""
    distance = []
    for factor in (1.0, 4.0, 16.0):
        mj = variant(assets.IRB1400_XML, Flexibility.GEARS, gear_stiffness=factor)
        mj.opt.timestep = 1.25e-4  # the stiffest gear rings at 1.6 kHz
        truth = VirtualRobot(load_model(mj)).run(brisk_motion()).truth
        apart = truth.tool_position - dh.pose(truth.motor_angle)[:, :3, 3]
        distance.append(np.linalg.norm(apart, axis=1).max())
    assert 0.2e-3 < distance[0] < 1.5e-3
    assert distance[1] / distance[0] == pytest.approx(1 / 4, rel=0.25)
    assert distance[2] / distance[0] == pytest.approx(1 / 16, rel=0.25)


def test_the_parallelogram_is_singular_at_90_degrees():
    """The cut loses a direction as 0.16 m cos(phi_3 - phi_2): the planner stops at 70 deg."""
    mj = variant(assets.IRB1400_XML, Flexibility.GEARS)
    model, linkage = load_model(mj), Linkage(mj)
    passive = [mj.joint(name).dofadr[0] for name in ("link_rod_y", "link_elbow")]
    for degrees in (0.0, 60.0, 70.0, 80.0, 90.0):
        phi = np.zeros(6)
        phi[2] = np.radians(degrees)
        data = at_rest_pose(model, phi)
        jacobian = linkage.jacobian(data)[:, passive]
        smallest = np.linalg.svd(jacobian[[0, 2]], compute_uv=False)[-1]
        assert np.abs(np.linalg.det(jacobian[[0, 2]])) == pytest.approx(
            0.6 * 0.16 * np.cos(phi[2]), abs=1e-12
        )
        assert smallest <= 0.16 * np.cos(phi[2]) + 1e-12


@pytest.mark.parametrize(("degrees", "newton"), [(0, 387), (60, 888), (70, 1180), (80, 2040)])
def test_the_force_in_the_rod_grows_towards_the_singularity(rigid, degrees, newton):
    mj = variant(assets.IRB1400_XML, Flexibility.RIGID)
    mj.jnt_limited[:] = 0
    phi = np.zeros(6)
    phi[2] = np.radians(degrees)
    data = held(load_model(mj), phi)
    rod = np.linalg.norm(data.efc_force[data.efc_id == mj.eq("rod_to_lever").id])
    assert rod == pytest.approx(newton, rel=0.05)
