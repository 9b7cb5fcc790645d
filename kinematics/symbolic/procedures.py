"""Symbolic kinematics of links: transforms, Jacobians, velocity and acceleration.

The functions take links whose parameters are complete, as the thesis writes them: theta of a
revolute link is its whole joint variable. `at(robot, phi)` gives such links for a `Robot`, whose
coupling and offset make joint variables from motor angles. A robot given instead of links stands
at phi = 0. Each function is a procedure of thesis Fig. 4.2; docs/toolbox.md has the table.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate
from operator import mul
from typing import Any

import sympy as sp

from ..dh import Convention, Joint, Link, Robot
from ..equations.chain import exact_parameters
from ..equations.coupling import joint_variables
from ..expressions.symbols import SymbolicMatrix, differentiate, exact, functions_of_time, moving, t

Links = Sequence[Link] | Robot


def dh_parameter(phi: Sequence[Any], theta0: Sequence[Any], theta_trans: Any) -> SymbolicMatrix:
    """theta = theta_trans phi + theta0 as a column. Thesis (4.10)."""
    return sp.Matrix(theta_trans) * sp.Matrix(list(phi)) + sp.Matrix(list(theta0))


def at(robot: Robot, phi: Sequence[Any]) -> Robot:
    """The robot's links with joint variables coupling phi + offset written into them."""
    if len(phi) != robot.n_joints:
        raise ValueError(f"{robot.name} has {robot.n_joints} motors, got {len(phi)} angles")
    variables = iter(joint_variables(robot, tuple(map(sp.sympify, phi))))
    links = []
    for link in robot.links:
        theta, d, a, alpha = exact_parameters(link)
        theta += next(variables) if link.joint is Joint.REVOLUTE else 0
        d += next(variables) if link.joint is Joint.PRISMATIC else 0
        links.append(Link(theta, d, a, alpha, link.joint))
    return Robot(links, convention=robot.convention, name=robot.name)


def motor_functions(robot: Robot) -> tuple[Any, ...]:
    """phi_1(t) ... phi_n(t)."""
    return tuple(moving("phi", i) for i in range(1, robot.n_joints + 1))


def matrix_a(link: Link, convention: Convention = Convention.STANDARD) -> SymbolicMatrix:
    """Link transform A_i. Thesis (3.29)."""
    theta, d, a, alpha = exact_parameters(link)
    c, s, ca, sa = sp.cos(theta), sp.sin(theta), sp.cos(alpha), sp.sin(alpha)
    if convention is Convention.MODIFIED:
        rows = [c, -s, 0, a], [s * ca, c * ca, -sa, -sa * d], [s * sa, c * sa, ca, ca * d]
    else:
        rows = [c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d]
    return sp.Matrix([*rows, [0, 0, 0, 1]])


def matrix_t(links: Links, start: int = 0) -> list[SymbolicMatrix]:
    """T_start^j for j = start, start + 1, ..., n: element j - start. Thesis (3.26).

    With start = 0, `matrix_t(robot)[i]` is T_0^i, and element 0 the identity.
    """
    robot = _complete(links)
    n = len(robot.links)
    if not 0 <= start <= n:
        raise ValueError(f"start must be a frame from 0 to {n}, got {start}")
    A = (matrix_a(link, robot.convention) for link in robot.links[start:])
    return list(accumulate(A, mul, initial=sp.eye(4)))


def position_t(T: SymbolicMatrix) -> SymbolicMatrix:
    """d of a homogeneous transform. Thesis (4.17)."""
    return T[:3, 3]


def rotation_t(T: SymbolicMatrix) -> SymbolicMatrix:
    """R of a homogeneous transform. Thesis (4.17)."""
    return T[:3, :3]


def transformation_t(p: Any, T: SymbolicMatrix) -> SymbolicMatrix:
    """The point p of the outer frame in the inner one: R p + d. Thesis (3.15), (4.24)."""
    p = sp.Matrix(p)
    if p.shape != (3, 1):
        raise ValueError(f"a point has 3 coordinates, got shape {p.shape}")
    return rotation_t(T) * p + position_t(T)


def _complete(links: Links) -> Robot:
    """A robot with nothing to add to its links."""
    if isinstance(links, Robot):
        plain = links.coupling.tolist() == sp.eye(links.n_joints).tolist() and not any(links.offset)
        return links if plain else at(links, [sp.S.Zero] * links.n_joints)
    return Robot(links)


def jacobian(links: Links, frame: int | None = None) -> SymbolicMatrix:
    """J = (J_v; J_omega), 6 x n, from the rates of the D-H joint variables. Thesis (3.39).

    frame: the frame whose origin moves, the last by default; columns of joints beyond it are zero.
    """
    robot = _complete(links)
    n = len(robot.links)
    frame = n if frame is None else frame
    if not 0 < frame <= n:
        raise ValueError(f"frame must be 1 to {n}, got {frame}")
    T = matrix_t(robot)
    origin, zero = position_t(T[frame]), sp.zeros(3, 1)
    # The z axis of a joint is that of frame i - 1, in the modified convention of frame i.
    shift = 0 if robot.convention is Convention.STANDARD else 1
    columns = []
    for i in robot.moving:
        z, joint = T[i + shift][:3, 2], robot.links[i].joint
        if i >= frame:
            columns.append([zero, zero])
        elif joint is Joint.REVOLUTE:
            columns.append([z.cross(origin - position_t(T[i + shift])), z])
        else:
            columns.append([z, zero])
    return sp.Matrix.hstack(*(sp.Matrix.vstack(*column) for column in columns))


def linear_jacobian(links: Links, frame: int | None = None) -> SymbolicMatrix:
    """J_v, 3 x n. Thesis (3.45), (3.46), 3.4.4; see `jacobian`."""
    return jacobian(links, frame)[:3, :]


def angular_jacobian(links: Links, frame: int | None = None) -> SymbolicMatrix:
    """J_omega, 3 x n. Thesis (3.51); see `jacobian`."""
    return jacobian(links, frame)[3:, :]


def motor_jacobian(robot: Robot, phi: Sequence[Any], frame: int | None = None) -> SymbolicMatrix:
    """J_phi = J_theta coupling, from the rates of the motors."""
    return jacobian(at(robot, phi), frame) * exact_coupling(robot)


def exact_coupling(robot: Robot) -> SymbolicMatrix:
    """The coupling with rational elements, n x n."""
    return sp.Matrix(robot.coupling.tolist()).applyfunc(lambda k: exact(float(k)))


def joint_rates(robot: Robot, variables: Sequence[Any] | None) -> SymbolicMatrix:
    """Time derivatives of the D-H joint variables, by the chain rule through each variable.

    A variable is a function of time, or a constant symbol that stands for one.
    """
    values = []
    for index in robot.moving:
        theta, d, _, _ = exact_parameters(robot.links[index])
        values.append(theta if robot.links[index].joint is Joint.REVOLUTE else d)
    if variables is None:
        variables = functions_of_time(values)
    rates = [sp.S.Zero] * len(values)
    for variable in variables:
        if sp.sympify(variable).is_number:  # the thesis lists zeros for constant links
            continue
        function = sp.Function(variable.name, real=True)(t) if variable.is_Symbol else variable
        for i, value in enumerate(values):
            value = value.xreplace({variable: function})
            rates[i] += differentiate(value, function) * function.diff(t)
    return sp.Matrix(rates)


def velocity(links: Links, variables: Sequence[Any] | None = None) -> SymbolicMatrix:
    """(v; omega) of the last frame: J times joint rates, coupling included. Thesis (3.52).

    variables: functions of time (or constant symbols standing for them) that vary; all functions
        of time by default.
    """
    robot = _complete(links)
    symbols: list[Any] = [v for v in variables or () if isinstance(v, sp.Symbol)]
    timed = {v: sp.Function(v.name, real=True)(t) for v in symbols}
    return jacobian(robot).xreplace(timed) * joint_rates(robot, variables)


def linear_velocity(links: Links, variables: Sequence[Any] | None = None) -> SymbolicMatrix:
    """v of the last frame. Thesis (3.52); see `velocity`."""
    return velocity(links, variables)[:3, :]


def angular_velocity(links: Links, variables: Sequence[Any] | None = None) -> SymbolicMatrix:
    """omega of the last frame. Thesis (3.52); see `velocity`."""
    return velocity(links, variables)[3:, :]


def acceleration(links: Links, variables: Sequence[Any] | None = None) -> SymbolicMatrix:
    """(a; omega') of the last frame. Thesis (3.57)."""
    return velocity(links, variables).diff(t)


def linear_acceleration(links: Links, variables: Sequence[Any] | None = None) -> SymbolicMatrix:
    """d/dt (J_v theta'). Thesis (3.57)."""
    return linear_velocity(links, variables).diff(t)


def angular_acceleration(links: Links, variables: Sequence[Any] | None = None) -> SymbolicMatrix:
    """d/dt (J_omega theta'). Thesis (3.57)."""
    return angular_velocity(links, variables).diff(t)


def joint_torques(links: Links, wrench: Any, frame: int | None = None) -> SymbolicMatrix:
    """tau = J^T F: joint torques that hold a wrench F = (force, moment) at a frame.

    Thesis (3.56); through a coupling, tau_phi = coupling^T tau.
    """
    return jacobian(links, frame).T * sp.Matrix(wrench)


def variable_link(link: Link, name: str = "q", index: int | None = None) -> Link:
    """The link with its joint variable replaced by q_i; a link of numbers stays. Thesis 4.3.2.

    index: by default the greatest index among the variables of the parameter, so that
        theta = phi_3(t) - phi_2(t) becomes q_3(t); without any index, q(t).
    """
    if link.joint is Joint.FIXED:
        return link
    field = "theta" if link.joint is Joint.REVOLUTE else "d"
    parameter = sp.sympify(getattr(link, field))
    if parameter.is_number:
        return link
    if index is None:
        names = [str(s) for s in parameter.free_symbols - {t}]
        names += [f.func.__name__ for f in functions_of_time([parameter])]
        tails = [name.rpartition("_")[2] for name in names if "_" in name]
        index = max((int(tail) for tail in tails if tail.isdecimal()), default=None)
    return replace(link, **{field: moving(name, index)})
