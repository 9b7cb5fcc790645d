"""The arm of an estimator with a closed chain: the IRB1400 and its parallelogram."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from armside import kinematics
from armside.assets import IRB1400_XML
from armside.ilc.estimation.process import first_order_hold, simulate
from armside.sim.cell import IRB1400_CELL
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.nonlinear_residual import nonlinear_residual
from armside.sim.estimation.observer import at_rest, dragged
from armside.sim.estimation.plausibility import rigid_position
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.robot.linkage import FreeMotion
from armside.sim.robot.mjcf import ModelError
from armside.sim.robot.model import load_model, robot_model

PHI = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
AXES = 6


@pytest.fixture(scope="module")
def robot():
    return load_model(IRB1400_XML)


@pytest.fixture(scope="module")
def arm(robot):
    return nominal_arm(robot)


def test_passive_joints_are_no_free_joints(robot, arm):
    assert (arm.n_free, arm.mj.nv) == (AXES, AXES + 2)
    structure = nominal_arm(robot, NominalCfg(structure=True))
    assert (structure.n_free, structure.mj.nv) == (AXES + 6, AXES + 9)


@pytest.mark.parametrize("structure", [False, True])
def test_the_reduced_arm_is_the_rollout_with_its_constraint(robot, structure):
    """Same springs, coupled; a motion of 0.1 mrad. The rollout closes the chain by forces."""
    arm = nominal_arm(robot, NominalCfg(structure=structure))
    K = arm.stiffness.copy()
    K[1, 2] = K[2, 1] = -0.1 * K[2, 2]
    arm = arm.with_springs(K, arm.damping)
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
    assert rigid_position(arm, phi) == pytest.approx(position, abs=1e-9)


def test_whole_motion_of_the_linkage_is_that_of_its_positions(robot):
    """Rates and accelerations of the passive joints against differences of closed positions."""
    arm = nominal_arm(robot, NominalCfg(structure=True))
    motion, step = arm.motion, 1e-4
    rng = np.random.default_rng(2)
    q, rate, acceleration = (0.2 * rng.standard_normal((3, arm.n_free))).reshape(3, -1)
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


def test_the_nonlinear_residual_vanishes_for_small_motions(arm):
    """Second order: a tenth of the motion leaves a hundredth of the residual."""
    linear = linearised(arm, PHI)
    t = np.linspace(0.0, 1.0, 50)[:, None]
    shape = np.sin(2 * np.pi * t * np.arange(1, AXES + 1) / 3.0)
    sizes = []
    for size in (1e-2, 1e-3):
        q, q_dot, q_ddot = size * shape, 5.0 * size * shape, 25.0 * size * shape
        found = nonlinear_residual(arm, linear, q, q_dot, q_ddot)
        sizes.append([np.abs(found.torque).max(), np.abs(found.reading).max()])
    ratio = np.divide(*sizes)
    assert ratio == pytest.approx(100.0, rel=0.2)


def test_the_path_of_an_observer_of_the_robot_itself_is_the_robots(robot):
    """Structure known, exact angles: what is left is the constraint of the two rollouts."""
    from armside.sim.laser import Cut, prepare
    from armside.sim.laser.learning import first_run
    from armside.sim.robot.effects import Effect

    truth = first_run(prepare(Cut(robot="irb1400", without=tuple(Effect)))).recording.truth
    arm = nominal_arm(robot, NominalCfg(structure=True))
    rate = np.gradient(truth.motor_angle, truth.time[1], axis=0)
    motion = dragged(arm, truth.motor_angle, rate)
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
