"""Dynamics against MuJoCo, against energies, and as laws of mechanics."""

import os

import mujoco
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from armside.kinematics import (
    IRB1400,
    LARGE_ROBOT,
    Convention,
    Joint,
    Link,
    Robot,
    compile_dynamics,
)
from armside.kinematics.equations import dynamics
from armside.kinematics.equations.inertial_model import Body, InertialModel, Motor
from armside.kinematics.rigid import link_transform
from armside.kinematics.symbolic.lagrange import symbolic_dynamics

ROUNDING = 1e-10  # relative
SIZES = (1, 2, 3, 4, 6, 8) if os.environ.get("ARMSIDE_CI") else (1, 2, 3, 6)
"""Numbers of joints."""
EXAMPLES = 30 if os.environ.get("ARMSIDE_CI") else 10


def mujoco_model(model: InertialModel) -> mujoco.MjModel:
    """The same bodies and joints, written for MuJoCo from the D-H table; joints are theta."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [float(g) for g in model.gravity]
    spec.compiler.balanceinertia = False
    standard = model.robot.convention is Convention.STANDARD
    parent, place = spec.worldbody, np.eye(4)
    for number, (link, body) in enumerate(zip(model.robot.links, model.bodies, strict=True)):
        about_x = link_transform(Link(a=link.a, alpha=link.alpha, joint=Joint.FIXED))
        about_z = link_transform(Link(theta=link.theta, d=link.d, joint=Joint.FIXED))
        if not standard:
            place = place @ about_x
        if link.moves:
            parent = parent.add_body(pos=place[:3, 3], quat=quaternion(place))
            hinge = link.joint is Joint.REVOLUTE
            kind = mujoco.mjtJoint.mjJNT_HINGE if hinge else mujoco.mjtJoint.mjJNT_SLIDE
            parent.add_joint(name=f"joint_{number}", type=kind, axis=[0, 0, 1])
            place = np.eye(4)
        place = place @ about_z
        if standard:
            place = place @ about_x
        add_inertia(parent, place, body)
    return spec.compile()


def quaternion(T: np.ndarray) -> np.ndarray:
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, T[:3, :3].ravel())
    return quat


def add_inertia(parent, place: np.ndarray, body: Body) -> None:
    """One rigid child for each link's body."""
    child = parent.add_body(pos=place[:3, 3], quat=quaternion(place))
    child.mass, child.ipos, child.iquat = body.mass, list(body.com), [1, 0, 0, 0]
    child.fullinertia = list(body.inertia)
    child.explicitinertial = True


@pytest.mark.parametrize("convention", Convention)
@pytest.mark.parametrize("n", SIZES)
def test_recursions_agree_with_mujoco(n, convention, random_model, random_robot, interpreted):
    rng = np.random.default_rng(n)
    model = random_model(rng, random_robot(rng, n, convention))
    twin = mujoco_model(model)
    data = mujoco.MjData(twin)
    M = model.robot.coupling
    phi, rate, rate_dot = rng.uniform(-1, 1, (3, n))
    offset = model.robot.offset
    data.qpos, data.qvel, data.qacc = M @ phi + offset, M @ rate, M @ rate_dot
    mujoco.mj_inverse(twin, data)
    D_theta = np.empty((n, n))
    mujoco.mj_fullM(twin, data, D_theta)
    rotor = np.diag([motor.inertia for motor in model.motors])
    friction = lost(model, rate)

    D = interpreted(dynamics.mass_matrix(model))(phi)
    assert_relative(D, M.T @ D_theta @ M + rotor)
    tau = interpreted(dynamics.inverse_dynamics(model))(phi, rate, rate_dot)
    assert_relative(tau, M.T @ data.qfrc_inverse + rotor @ rate_dot + friction)
    bias = interpreted(dynamics.bias_torque(model))(phi, rate)
    assert_relative(bias, M.T @ data.qfrc_bias + friction)
    solved = interpreted(dynamics.forward_dynamics(model))(phi, rate, tau)
    assert_relative(solved, rate_dot, 1e-9)  # conditioning of D


def lost(model: InertialModel, rate: np.ndarray) -> np.ndarray:
    """Friction torque of each motor."""
    viscous = np.array([motor.viscous for motor in model.motors])
    coulomb = np.array([motor.coulomb for motor in model.motors])
    return viscous * rate + coulomb * np.sign(rate)


def assert_relative(actual, expected, tolerance=ROUNDING):
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(actual / scale, expected / scale, rtol=0, atol=tolerance)


@pytest.mark.parametrize("convention", Convention)
@pytest.mark.parametrize("n", [1, 2, 3])
def test_recursions_agree_with_energies(n, convention, random_model, random_robot, interpreted):
    """Fully symbolic Lagrange and Christoffel against Newton-Euler, evaluated at one point."""
    rng = np.random.default_rng(10 * n)
    model = random_model(rng, random_robot(rng, n, convention, square=n == 3))
    full = symbolic_dynamics(model)
    phi, rate, rate_dot = rng.uniform(-1, 1, (3, n))
    symbols = [*full.phi, *full.phi_dot]
    evaluate = sp.lambdify(symbols, [full.D, full.C, full.g, full.f], cse=True)
    D, C, g, f = evaluate(*phi, *rate)
    assert_relative(interpreted(dynamics.mass_matrix(model))(phi), D)
    assert_relative(interpreted(dynamics.coriolis_matrix(model))(phi, rate), C)
    assert_relative(interpreted(dynamics.gravity_torque(model))(phi), g[:, 0])
    tau = D @ rate_dot + C @ rate + g[:, 0] + f[:, 0]
    assert_relative(interpreted(dynamics.inverse_dynamics(model))(phi, rate, rate_dot), tau)


@pytest.fixture(scope="module")
def arm(random_model):
    """The large robot's geometry through the small one's coupling, with random bodies."""
    robot = Robot(LARGE_ROBOT.links, IRB1400.coupling, IRB1400.offset)
    return random_model(np.random.default_rng(2), robot)


@pytest.fixture(scope="module")
def functions(arm, interpreted):
    names = "mass_matrix inverse_dynamics gravity_torque bias_torque coriolis_matrix"
    return {name: interpreted(getattr(dynamics, name)(arm)) for name in names.split()}


six = st.tuples(*[st.floats(-3, 3)] * 6).map(np.array)


@settings(max_examples=EXAMPLES, deadline=None)
@given(phi=six, rate=six)
def test_inertia_rate_minus_twice_coriolis_is_skew(functions, phi, rate):
    """(2.16), with dD/dt by central differences."""
    h = 1e-6
    D = functions["mass_matrix"]
    D_dot = (D(phi + h * rate) - D(phi - h * rate)) / (2 * h)
    N = D_dot - 2 * functions["coriolis_matrix"](phi, rate)
    scale = max(1.0, np.abs(D_dot).max())
    np.testing.assert_allclose((N + N.T) / scale, 0, atol=1e-7)


@settings(max_examples=EXAMPLES, deadline=None)
@given(phi=six, rate=six, rate_dot=six)
def test_power_of_the_motors_is_the_change_of_energy_and_the_friction(
    arm, functions, phi, rate, rate_dot
):
    tau = functions["inverse_dynamics"](phi, rate, rate_dot)
    friction = lost(arm, rate)
    h = 1e-5

    def kinetic(t):
        v = rate + rate_dot * t
        return v @ functions["mass_matrix"](phi + rate * t + rate_dot * t * t / 2) @ v / 2

    change = (kinetic(h) - kinetic(-h)) / (2 * h)
    lifting = functions["gravity_torque"](phi) @ rate
    scale = 1 + abs(tau @ rate) + rate @ rate * 10
    assert tau @ rate == pytest.approx(change + lifting + friction @ rate, abs=1e-6 * scale)


def test_rotor_inertia_acts_on_the_motor_and_not_through_the_coupling(interpreted):
    links = [Link(a=1), Link(a=1)]
    robot = Robot(links, coupling=[[1, 0], [-1, 1]])
    massless = [Body(mass=0)] * 2
    model = InertialModel(robot, massless, [Motor(inertia=3), Motor(inertia=5)])
    D = interpreted(dynamics.mass_matrix(model))(np.zeros(2))
    np.testing.assert_allclose(D, np.diag([3, 5]), rtol=0, atol=1e-15)


def test_two_link_arm_is_the_textbook_one():
    """Point masses at the tips of a planar arm, gravity along -y."""
    m1, m2, l1, l2, g = sp.symbols("m1 m2 l1 l2 g", positive=True)
    robot = Robot([Link(a=l1), Link(a=l2)])
    model = InertialModel(robot, [Body(mass=m1), Body(mass=m2)], gravity=(0, -g, 0))
    full = symbolic_dynamics(model)
    (q1, q2), (v1, v2) = full.phi, full.phi_dot
    c2 = sp.cos(q2)
    D12 = m2 * (l2**2 + l1 * l2 * c2)
    D = [[m1 * l1**2 + m2 * (l1**2 + 2 * l1 * l2 * c2 + l2**2), D12], [D12, m2 * l2**2]]
    assert sp.simplify(full.D - sp.Matrix(D)) == sp.zeros(2)
    h = -m2 * l1 * l2 * sp.sin(q2)
    C = [[h * v2, h * (v1 + v2)], [-h * v1, 0]]
    assert sp.simplify(full.C - sp.Matrix(C)) == sp.zeros(2)
    far = m2 * l2 * g * sp.cos(q1 + q2)
    weights = [(m1 + m2) * l1 * g * sp.cos(q1) + far, far]
    assert sp.simplify(full.g - sp.Matrix(weights)) == sp.zeros(2, 1)
    N = (full.D.diff(q1) * v1 + full.D.diff(q2) * v2) - 2 * full.C
    assert sp.simplify(N + N.T) == sp.zeros(2)


@pytest.mark.parametrize(
    ("make", "given", "said"),
    [
        (Body, {"mass": -1}, "mass must be >= 0"),
        (Body, {"mass": 1, "inertia": (1, 1, 3, 0, 0, 0)}, "triangle inequality"),
        (Body, {"mass": np.nan}, "mass must be finite"),
        (Body, {"mass": 1, "com": (0, 0)}, "com must have 3 values, got 2"),
        (Motor, {"inertia": -1}, "inertia must be >= 0"),
        (InertialModel, {"bodies": [Body(mass=1)] * 5}, "needs 6 bodies, got 5"),
        (InertialModel, {"bodies": [Body(mass=1)] * 6, "motors": [Motor()]}, "6 motors, got 1"),
    ],
)
def test_masses_that_no_body_has_are_refused(make, given, said):
    robot = {"robot": LARGE_ROBOT} if make is InertialModel else {}
    with pytest.raises(ValueError, match=said):
        make(**robot, **given)


def test_a_model_with_symbols_cannot_be_compiled():
    model = InertialModel(Robot([Link(a=1)]), [Body(mass=sp.Symbol("m"))])
    with pytest.raises(ValueError, match="has symbols: m"):
        compile_dynamics(model)
