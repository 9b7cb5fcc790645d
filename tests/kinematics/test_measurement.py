"""Equations of a filter: what sensors read and how states move, with derived Jacobians."""

import mujoco
import numpy as np
import pytest
import sympy as sp

from armside.kinematics import IRB1400, IRB1400_IMU, Convention, Joint, Link, Robot, compile
from armside.kinematics.compiled import compile_dynamics
from armside.kinematics.equations import derivative
from armside.kinematics.equations import forward_kinematics as motion
from armside.kinematics.equations import state_equations as process
from armside.kinematics.equations.imu_equations import measurement, measurement_jacobian
from armside.kinematics.equations.inertial_model import Body, Motor, RobotModel
from armside.kinematics.equations.program import Block, Program

G = 9.82
GRAVITY = np.array([0, 0, -G])
RNG = np.random.default_rng(0)
PHI, PHI_DOT, PHI_DDOT = RNG.uniform(-1, 1, (3, 6))


def test_imu_at_rest_reads_gravity_and_nothing_else(interpreted):
    y = interpreted(measurement(IRB1400_IMU))(np.zeros(6), np.zeros(6), np.zeros(6))
    np.testing.assert_allclose(y, [*np.zeros(9), 0, 0, G], rtol=0, atol=1e-12)


def test_imu_reads_the_tool_motion_turned_into_its_axes(interpreted):
    """The recursion in moving axes against pose, Jacobian and acceleration in base axes."""
    y = interpreted(measurement(IRB1400_IMU))(PHI, PHI_DOT, PHI_DDOT)
    functions = compile(IRB1400_IMU)
    R = functions.pose(PHI)[:3, :3]
    omega = (functions.jacobian(PHI) @ PHI_DOT)[3:]
    a = functions.acceleration(PHI, PHI_DOT, PHI_DDOT)[:3]
    np.testing.assert_allclose(y[:6], PHI, rtol=0, atol=0)
    np.testing.assert_allclose(y[6:9], R.T @ omega, rtol=0, atol=1e-12)
    np.testing.assert_allclose(y[9:], R.T @ (a - GRAVITY), rtol=0, atol=1e-12)


@pytest.mark.parametrize("frame", range(1, 9))
def test_a_sensor_may_sit_on_any_link(frame, interpreted):
    """The same as a robot that ends there, its later motors irrelevant."""
    y = interpreted(measurement(IRB1400_IMU, frame=frame))(PHI, PHI_DOT, PHI_DDOT)
    n = min(frame, 6)
    shorter = Robot(
        IRB1400_IMU.links[:frame], IRB1400.coupling[:n, :n], IRB1400.offset[:n], name="part"
    )
    expected = interpreted(measurement(shorter))(PHI[:n], PHI_DOT[:n], PHI_DDOT[:n])
    np.testing.assert_allclose(y[6:], expected[n:], rtol=0, atol=1e-13)


def test_a_frame_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="frame must be 1 to 8, got 9"):
        measurement(IRB1400_IMU, frame=9)


def test_mujoco_sensors_read_the_same(interpreted):
    """Joint by joint the IRB1400 in MuJoCo with an IMU site, driven to the same motion."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0, 0, -G]
    body, place = spec.worldbody, np.eye(4)
    from armside.kinematics.inverse.wrist_arm import link_transform

    for number, link in enumerate(IRB1400_IMU.links):
        if link.moves:
            quat = np.empty(4)
            mujoco.mju_mat2Quat(quat, place[:3, :3].ravel())
            body = body.add_body(pos=place[:3, 3], quat=quat)
            body.add_joint(name=f"j{number}", axis=[0, 0, 1])
            body.mass, body.inertia, body.explicitinertial = 1, [1, 1, 1], True
            place = np.eye(4)
        place = place @ link_transform(link)
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, place[:3, :3].ravel())
    body.add_site(name="imu", pos=place[:3, 3], quat=quat)
    for kind in (mujoco.mjtSensor.mjSENS_GYRO, mujoco.mjtSensor.mjSENS_ACCELEROMETER):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="imu")
    twin = spec.compile()
    data = mujoco.MjData(twin)
    M = IRB1400.coupling
    data.qpos, data.qvel = IRB1400.joint_variables(PHI), M @ PHI_DOT
    data.qacc = M @ PHI_DDOT
    mujoco.mj_inverse(twin, data)
    y = interpreted(measurement(IRB1400_IMU))(PHI, PHI_DOT, PHI_DDOT)
    np.testing.assert_allclose(y[6:], data.sensordata, rtol=0, atol=1e-11)

    jacp, jacr = np.empty((3, 6)), np.empty((3, 6))
    mujoco.mj_forward(twin, data)
    mujoco.mj_jacSite(twin, data, jacp, jacr, 0)
    J = compile(IRB1400_IMU).jacobian(PHI)
    np.testing.assert_allclose(J, np.vstack([jacp, jacr]) @ M, rtol=0, atol=1e-12)
    T = compile(IRB1400_IMU).pose(PHI)
    np.testing.assert_allclose(T[:3, 3], data.site("imu").xpos, rtol=0, atol=1e-12)


def central(function, x: np.ndarray, h: float = 1e-6) -> np.ndarray:
    columns = [(function(x + h * e) - function(x - h * e)) / (2 * h) for e in np.eye(len(x))]
    return np.stack(columns, axis=-1)


def test_measurement_jacobian_is_the_finite_difference(interpreted):
    read = interpreted(measurement(IRB1400_IMU))
    H = interpreted(measurement_jacobian(IRB1400_IMU))(PHI, PHI_DOT, PHI_DDOT)
    x = np.concatenate([PHI, PHI_DOT, PHI_DDOT])
    expected = central(lambda x: read(x[:6], x[6:12], x[12:]), x)
    assert H.shape == (12, 18)
    np.testing.assert_allclose(H, expected, rtol=0, atol=1e-8)


def test_measurement_jacobian_of_a_small_arm_is_the_symbolic_one():
    robot = Robot([Link(a="l1", alpha="pi/2"), Link(a="l2")])
    y = sp.Matrix(measurement(robot).expressions())
    H = measurement_jacobian(robot)
    variables = [e for block in H.inputs[:3] for e in block.elements]
    expected = y.jacobian(variables)
    assert sp.simplify(sp.Matrix(8, 6, H.expressions()) - expected) == sp.zeros(8, 6)


@pytest.fixture(scope="module")
def model(random_model, random_robot):
    rng = np.random.default_rng(7)
    return random_model(rng, random_robot(rng, 2, Convention.STANDARD))


def test_rigid_process_jacobian_is_the_finite_difference(model, tmp_path):
    functions = compile_dynamics(model, cache=tmp_path)
    x, tau = RNG.uniform(-1, 1, 4), RNG.uniform(-1, 1, 2)
    F = functions.rigid_rate_jacobian(x, tau)
    expected = central(lambda x: functions.rigid_rate(x, tau), x)
    np.testing.assert_allclose(F, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    assert np.array_equal(functions.rigid_rate_jacobian(x, tau, out=np.empty((4, 4))), F)
    with pytest.raises(ValueError, match=r"x must be \(4,\) and tau \(2,\)"):
        functions.rigid_rate_jacobian(x[:3], tau)


def test_flexible_process_jacobian_is_the_finite_difference(model, interpreted):
    rate = interpreted(process.flexible_rate(model))
    along = interpreted(process.rate_tangent(process.flexible_rate(model)))
    x, tau = RNG.uniform(-1, 1, 8), RNG.uniform(-1, 1, 2)
    F = np.stack([along(x, tau, e) for e in np.eye(8)], axis=-1)
    expected = central(lambda x: rate(x, tau), x)
    np.testing.assert_allclose(F, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_flexible_joint_of_one_link_is_the_two_mass_model():
    """(8.1), (8.2) on the arm side: motor inertia rg^2 J_m, ... with the signs of the errata."""
    J, Ja, k, d, fm = sp.symbols("J J_a k d f_m", positive=True)
    motor = Motor(inertia=J, viscous=fm, stiffness=k, damping=d)
    body = Body(mass=0, inertia=(0, 0, Ja, 0, 0, 0))
    one = RobotModel(Robot([Link()]), [body], [motor], gravity=(0, 0, 0))
    program = process.flexible_rate(one)
    qa, qm, qad, qmd = program.inputs[0].elements
    (tau,) = program.inputs[1].elements
    spring = k * (qm - qa) + d * (qmd - qad)
    expected = [qad, qmd, spring / Ja, (tau - fm * qmd - spring) / J]
    difference = sp.Matrix(program.expressions()) - sp.Matrix(expected)
    assert sp.simplify(difference) == sp.zeros(4, 1)
    A = sp.Matrix(program.expressions()).jacobian([qa, qm, qad, qmd])
    assert sp.simplify(A.det()) == 0  # the rigid-body pole at zero, lost with (2.18) as printed


def test_stiff_springs_move_the_arm_as_rigid_joints_do(model, interpreted):
    """Both halves given one motion and the torques that rigid dynamics asks for."""
    stiff = [
        Motor(inertia=m.inertia, viscous=m.viscous, coulomb=m.coulomb, stiffness=1e6)
        for m in model.motors
    ]
    model = RobotModel(model.robot, model.bodies, stiff, model.gravity)
    phi, rate, tau = RNG.uniform(-1, 1, (3, 2))
    from armside.kinematics.equations.dynamics import forward_dynamics

    rigid = interpreted(forward_dynamics(model))(phi, rate, tau)
    # The deflection at which arm and motor accelerate alike carries the arm's share of torque.
    flexible = interpreted(process.flexible_rate(model))

    def gap(deflection):
        x = np.concatenate([phi, phi + deflection, rate, rate])
        a = flexible(x, tau)[4:]
        return a[2:] - a[:2]

    slope = central(gap, np.zeros(2), h=1e-7)
    deflection = np.linalg.solve(slope, -gap(np.zeros(2)))
    x = np.concatenate([phi, phi + deflection, rate, rate])
    np.testing.assert_allclose(flexible(x, tau)[4:6], rigid, rtol=1e-6)


def test_flexible_joints_need_springs(random_robot):
    robot = random_robot(np.random.default_rng(0), 1, Convention.STANDARD)
    model = RobotModel(robot, [Body(mass=1)] * len(robot.links), [Motor(inertia=1)])
    with pytest.raises(ValueError, match="motor 1 needs a stiffness and an inertia"):
        process.flexible_rate(model)


def test_tangent_of_the_jacobian_is_its_time_derivative(interpreted):
    J = interpreted(motion.jacobian(IRB1400))
    J_dot = interpreted(motion.jacobian_rate(IRB1400))(PHI, PHI_DOT)
    h = 1e-6
    expected = (J(PHI + h * PHI_DOT) - J(PHI - h * PHI_DOT)) / (2 * h)
    np.testing.assert_allclose(J_dot, expected, rtol=0, atol=1e-9)


def test_derivative_of_a_sign_is_zero_and_of_an_unknown_input_an_error():
    x = sp.Symbol("x", real=True)
    block = Block("x", (1,), (x,))
    program = Program("p", (block,), (), (Block("y", (1,), (x**2 + 3 * sp.sign(x),)),))
    H = derivative.jacobian(program, ("x",))
    assert H.expressions() == (2 * x,)
    with pytest.raises(ValueError, match=r"unknown inputs \['z'\]; inputs: x"):
        derivative.jacobian(program, ("z",))


def test_prismatic_joints_carry_sensors_too(interpreted):
    """A lift with an accelerometer reads gravity plus its own acceleration."""
    lift = Robot([Link(joint=Joint.PRISMATIC)])
    y = interpreted(measurement(lift))([0.3], [2.0], [1.5])
    np.testing.assert_allclose(y, [0.3, 0, 0, 0, 0, 0, G + 1.5], rtol=0, atol=1e-14)
