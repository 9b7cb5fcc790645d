"""The arm of an estimator with a closed chain: the IRB1400 and its parallelogram."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from armside import kinematics
from armside.arrays import Array
from armside.assets import IRB1400_XML
from armside.ilc.estimation.process import first_order_hold, simulate
from armside.sim.cell import IRB1400_CELL
from armside.sim.estimation.deflection import Deflection, deflection
from armside.sim.estimation.elasticity import nominal_elasticity
from armside.sim.estimation.estimator import tool_path
from armside.sim.estimation.linearised_arm import at_rest, linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.estimation.rigid_motion import rigid_motion
from armside.sim.estimation.structure import with_structure
from armside.sim.laser import Cut, prepare
from armside.sim.laser.loop import first_run
from armside.sim.robot.effects import Effect
from armside.sim.robot.linkage import FreeMotion
from armside.sim.robot.mjcf import ModelError
from armside.sim.robot.model import load_model, robot_model

from .rollout import dragged, observe

PHI = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
AXES = 6


@pytest.fixture(scope="module")
def robot():
    return load_model(IRB1400_XML)


@pytest.fixture(scope="module")
def arm(robot):
    return nominal_arm(robot)


@pytest.fixture(scope="module")
def structural(robot):
    """The arm with its structure."""
    return nominal_arm(robot, NominalCfg(structure=True))


def test_passive_joints_are_no_free_joints(arm, structural):
    assert (arm.n_free, arm.mj.nv) == (AXES, AXES + 2)
    assert (structural.n_free, structural.mj.nv) == (AXES + 6, AXES + 9)


@pytest.mark.parametrize("structure", [False, True])
def test_the_reduced_arm_is_the_rollout_with_its_constraint(robot, structure):
    """Same springs; a motion of 0.1 mrad. The rollout closes the chain by forces."""
    arm = nominal_arm(robot, NominalCfg(structure=structure))
    t = np.arange(2000) * arm.mj.opt.timestep
    phi = PHI + 1e-4 * np.sin(2 * np.pi * 3.0 * t)[:, None] ** 3
    phi_dot = np.gradient(phi, t[1], axis=0)
    motion = dragged(arm, phi, phi_dot)
    A, B = linearised(arm, PHI).dynamics()
    x = simulate(*first_order_hold(A, B, t[1]), np.hstack((phi - PHI, phi_dot)))
    moved = x[:, : arm.n_free]
    assert np.abs(motion.q - motion.q[0] - moved).max() < 0.002 * np.abs(moved).max()


def test_the_rigid_arm_is_the_robot_of_the_toolbox(arm):
    rng = np.random.default_rng(1)
    low, high = IRB1400_CELL.limits.lower, IRB1400_CELL.limits.upper
    phi = 0.4 * rng.uniform(low, high, (20, AXES))
    position = kinematics.compile(kinematics.IRB1400).pose(phi)[:, :3, 3]
    # Closed to 1e-14 m, but the rod's numbers in the file have seven digits.
    assert positions(arm, phi) == pytest.approx(position, abs=1e-9)


def positions(arm, phi):
    """(N, 3) [m], the tool of the rigid arm at motor angles (N, 6)."""
    motion, q, found = arm.motion, np.zeros(arm.n_free), np.empty((len(phi), 3))
    data, site = motion.data(), motion.mj.site("tool0").id
    for i, angles in enumerate(phi):
        q[arm.axes] = angles
        motion.place(data, q)
        mujoco.mj_kinematics(motion.mj, data)
        found[i] = data.site_xpos[site]
    return found


def test_springs_across_the_axes_of_a_linkage_leave_the_rigid_arm_as_it_is(robot):
    """Those of axis 3, which a crank drives, stand behind the elbow that follows it."""
    arm = nominal_arm(with_structure(robot), NominalCfg(structure=True))
    assert (arm.n_free, arm.mj.nv) == (AXES + 6, AXES + 9)
    hinges = [arm.mj.joint(f"across_{i}").id for i in range(6)]
    bodies = [arm.mj.body(int(body)).name for body in arm.mj.jnt_bodyid[hinges]]
    assert bodies == ["frame"] * 2 + ["lower_arm"] * 2 + ["upper_arm"] * 2
    phi = PHI + 0.1 * np.random.default_rng(3).standard_normal((20, AXES))
    assert positions(arm, phi) == pytest.approx(positions(nominal_arm(robot), phi), abs=1e-9)


def test_deflection_along_a_linkage_is_the_motion_of_its_rollout(robot):
    """As of an open arm, `test_deflection`: springs are linear in both."""
    arm = nominal_arm(with_structure(robot), NominalCfg(structure=True))
    springs = nominal_elasticity(robot, arm)
    springs = springs.scaled(np.ones(arm.n_free), 1.0, 1.0, 0.0)
    time: Array = np.arange(400, dtype=np.float64) * 0.004
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.clip((time - 0.3) / 1.0, 0.0, 1.0))
    phi = PHI + 0.05 * ramp[:, None] * np.array([1.0, -0.5, 0.7, 1.0, -1.0, 0.5])
    motion = rigid_motion(arm, time, phi)
    bent = deflection(motion, springs)
    none = np.zeros_like(bent.angle)
    still = Deflection(none, none, none)
    found, rigid = (tool_path(motion, each)[:, :3] for each in (bent, still))
    whole = relative_to_start(observe(arm, phi, 0.004).tool_position[::8])[:, :3]
    assert np.abs(found - whole).max() < 0.1 * np.abs(rigid - whole).max()


def test_whole_motion_of_the_linkage_is_that_of_its_positions(structural):
    """Rates and accelerations of the passive joints against differences of closed positions."""
    motion, step = structural.motion, 1e-4
    rng = np.random.default_rng(2)
    q, rate, acceleration = 0.2 * rng.standard_normal((3, structural.n_free))
    data, whole = motion.data(), []
    for t in (-step, 0.0, step):
        motion.place(data, q + rate * t + acceleration * t**2 / 2.0)
        whole.append(data.qpos.copy())
    motion.move(data, q, rate, acceleration)
    before, here, after = whole
    assert data.qvel == pytest.approx((after - before) / (2.0 * step), abs=1e-6)
    assert data.qacc == pytest.approx((after - 2.0 * here + before) / step**2, abs=1e-5)


def test_rest_is_where_the_rollout_stays(arm):
    """But for what the constraint gives way under the arm's weight."""
    motion = dragged(arm, np.tile(PHI, (400, 1)), np.zeros((400, AXES)))
    assert np.abs(motion.q - at_rest(arm, PHI)).max() < 1e-7


def test_a_chain_without_cuts_is_left_as_it_is():
    mj = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><inertial mass='1' pos='0 0 0' diaginertia='1 1 1'/>"
        "<joint name='a'/></body></worldbody></mujoco>"
    )
    motion = FreeMotion(mj)
    assert motion.mj is mj
    assert motion.joints.tolist() == [0]


def test_the_path_of_an_observer_of_the_robot_itself_is_the_robots(structural):
    """Structure known, exact angles: what is left is the constraint of the two rollouts."""
    truth = first_run(prepare(Cut(robot="irb1400", without=tuple(Effect)))).recording.truth
    rate = np.gradient(truth.motor_angle, truth.time[1], axis=0)
    motion = dragged(structural, truth.motor_angle, rate)
    path, true = map(relative_to_start, (motion.tool_position[::8], truth.tool_position[::8]))
    assert np.abs(path - true).max() <= 1e-6


def test_brakes_are_released_and_other_equalities_refused(robot):
    assert any(e.name.startswith("brake_") for e in robot.parsed().equalities)
    spec = robot.parsed()
    mimic = spec.add_equality(name="mimic", type=mujoco.mjtEq.mjEQ_JOINT)
    mimic.name1, mimic.name2 = "motor_5", "motor_6"
    mimic.objtype = mujoco.mjtObj.mjOBJ_JOINT
    with pytest.raises(ModelError, match="not the equality 'mimic'"):
        nominal_arm(replace(robot_model(spec), spec=spec))
