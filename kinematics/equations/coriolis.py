"""The Coriolis matrix of (2.15) without Christoffel symbols, yet the same matrix.

With all bodies seen from the base origin, and for each body J = (J_v; J_omega), M its 6 x 6
inertia, p its linear momentum and c its centre of mass,

    C = sum J^T (M J' + B J),   B = [0, -S(p); 0, E],
    E = (S(omega) I - I S(omega) - S(I omega)) / 2 - m S(c) S(c'),   I about the centre of mass,

which makes D' - 2 C skew symmetric (2.16): E is the body-level form of Echeandia and Wensing,
"Numerical Methods to Compute the Coriolis Matrix and Christoffel Symbols for Rigid-Body Systems"
(2021). p and E of bodies add up, so a joint sees everything beyond it as one.
"""

from collections.abc import Sequence
from typing import Any

import sympy as sp

from ..expressions.rotation_symbolic import skew
from ..expressions.symbols import Expression
from .chain import (
    UPPER,
    ZERO,
    Matrix,
    Vector,
    added,
    combined,
    crossed,
    scaled,
    symmetric,
    tensor_times,
)
from .coupling import congruent, joint_rates
from .dynamics import inputs_of, joint_chain, notes
from .inertial_model import InertialModel
from .program import Argument, StraightLineProgram, Tape, separated
from .recursion import JointTransform

Six = tuple[Vector, Vector]
Rows = tuple[Vector, Vector, Vector]


@separated
def coriolis_matrix(model: InertialModel) -> StraightLineProgram:
    """C(phi, phi_dot), n x n, in motor angles: coupling^T C_theta coupling."""
    tape = Tape()
    inputs = inputs_of(model, "phi", "phi_dot")
    chain = joint_chain(model, tape)
    rates = joint_rates(model.robot, tape, inputs[1].elements)
    C = congruent(model.robot, tape, _joint_coriolis(tape, chain, rates))
    out = Argument("C", (len(C), len(C)), tuple(e for row in C for e in row))
    return tape.program("coriolis_matrix", inputs, [out], notes(model))


def _joint_coriolis(
    tape: Tape, chain: Sequence[JointTransform], rates: Sequence[Expression]
) -> Matrix:
    n = len(chain)
    frames = _frames(tape, chain)
    S = [_screw(tape, joint, frame) for joint, frame in zip(chain, frames, strict=True)]
    V: Six = (ZERO, ZERO)
    S_dot: list[Six] = []
    bodies = []
    for i in range(n):
        S_dot.append(_bracket(tape, V, S[i]))
        v, w = (added(tape, V[k], scaled(tape, rates[i], S[i][k])) for k in range(2))
        V = (v, w)
        bodies.append(_body(tape, chain[i], frames[i], V))
    C: Matrix = [[sp.S.Zero] * n for _ in range(n)]
    whole = [sp.S.Zero] * 22
    for far in reversed(range(n)):
        whole = [tape(a + b) for a, b in zip(whole, bodies[far], strict=True)]
        for near in range(far + 1):
            for i, j in {(near, far), (far, near)}:
                C[i][j] = _dot(tape, S[i], _weighted(tape, whole, S_dot[j], S[j]))
    return C


def _frames(tape: Tape, chain: Sequence[JointTransform]) -> list[tuple[Rows, Vector]]:
    """Axes (columns) and origin of each body frame in base axes."""
    x, y, z = sp.eye(3).tolist()
    axes: Rows = (tuple(x), tuple(y), tuple(z))
    origin = ZERO
    frames = []
    for joint in chain:
        for axis, distance in zip(axes, joint.translation, strict=True):
            origin = added(tape, origin, scaled(tape, distance, axis))
        x, y, z = (_mixed(tape, axes, tuple(joint.segment.rotation[:, k])) for k in range(3))
        c, s = joint.cosine, joint.sine
        axes = (combined(tape, c, x, s, y), combined(tape, -s, x, c, y), z)
        frames.append((axes, origin))
    return frames


def _mixed(tape: Tape, axes: Rows, v: Sequence[Any]) -> Vector:
    """The vector with components v along the axes."""
    parts = [tape(sp.Add(*(axes[k][i] * v[k] for k in range(3)))) for i in range(3)]
    return (parts[0], parts[1], parts[2])


def _screw(tape: Tape, joint: JointTransform, frame: tuple[Rows, Vector]) -> Six:
    """(v, omega) at the base origin of unit joint rate."""
    axes, origin = frame
    if joint.revolute:
        return crossed(tape, origin, axes[2]), axes[2]
    return axes[2], ZERO


def _bracket(tape: Tape, V: Six, S: Six) -> Six:
    """Rate of a screw that moves with V."""
    linear = added(tape, crossed(tape, V[1], S[0]), crossed(tape, V[0], S[1]))
    return linear, crossed(tape, V[1], S[1])


def _body(
    tape: Tape, joint: JointTransform, frame: tuple[Rows, Vector], V: Six
) -> list[Expression]:
    """m, h (3), I_origin (6), p (3), E (9) of one body group: all add up over bodies."""
    axes, origin = frame
    inertia = joint.segment.inertia
    m = inertia.mass
    h_local = _mixed(tape, axes, inertia.moment)  # first moment about the body frame's origin
    h = added(tape, h_local, scaled(tape, m, origin))
    tensor = _in_base_axes(tape, axes, inertia.tensor)  # about the body frame's origin, base axes
    omega = V[1]
    at_origin = added(tape, V[0], crossed(tape, omega, origin))
    # With c = o + r, r in the body: -m S(c) S(c') = -S(o) S(p) - S(h) S(o') - m S(r) S(omega x r),
    # and the last term is what `_rotational` gains when its tensor is about o instead of c.
    spin = crossed(tape, omega, h_local)
    p = added(tape, scaled(tape, m, at_origin), spin)
    E = _rotational(tape, tensor, omega)
    E = _minus_double_skew(tape, E, origin, p)
    E = _minus_double_skew(tape, E, h_local, at_origin)
    about = _parallel(tape, tensor, m, h_local, origin)
    return [m, *h, *about, *p, *(e for row in E for e in row)]


def _rotational(tape: Tape, tensor: Sequence[Expression], omega: Vector) -> Matrix:
    """(S(omega) I - I S(omega) - S(I omega)) / 2 for a tensor about a point of the body."""
    K = skew(tensor_times(tape, tensor, omega))
    WI = (skew(omega) * symmetric(tensor)).applyfunc(tape)
    # I S(omega) = -(S(omega) I)^T
    return [[tape((WI[i, j] + WI[j, i] - K[i, j]) / 2) for j in range(3)] for i in range(3)]


def _minus_double_skew(tape: Tape, E: Matrix, u: Vector, v: Vector) -> Matrix:
    """E - S(u) S(v) = E - v u^T + (u . v) 1."""
    trace = tape(u[0] * v[0] + u[1] * v[1] + u[2] * v[2])
    return [
        [tape(E[i][j] - v[i] * u[j] + (trace if i == j else 0)) for j in range(3)] for i in range(3)
    ]


def _in_base_axes(tape: Tape, axes: Rows, tensor: Sequence[Expression]) -> list[Expression]:
    full = symmetric(tensor)  # rows in body axes; half: columns in base axes
    half = [_mixed(tape, axes, tuple(full[i, :])) for i in range(3)]
    return [tape(sp.Add(*(axes[k][i] * half[k][j] for k in range(3)))) for i, j in UPPER]


def _parallel(
    tape: Tape, tensor: Sequence[Expression], m: Expression, h: Vector, r: Vector
) -> list[Expression]:
    """Tensor about the base origin, from which the old origin lies at r."""
    moved = added(tape, h, scaled(tape, m, r))
    total = tape(sp.Add(*(r[k] * (h[k] + moved[k]) for k in range(3))))
    return [
        tape(old + (total if i == j else 0) - r[i] * moved[j] - h[i] * r[j])
        for old, (i, j) in zip(tensor, UPPER, strict=True)
    ]


def _weighted(tape: Tape, whole: Sequence[Expression], S_dot: Six, S: Six) -> Six:
    """M S' + B S."""
    m, h, tensor, p, E = whole[0], whole[1:4], whole[4:10], whole[10:13], whole[13:]
    h_, p_ = (h[0], h[1], h[2]), (p[0], p[1], p[2])
    v, w = S_dot
    force = added(tape, scaled(tape, m, v), crossed(tape, w, h_))
    force = added(tape, force, crossed(tape, S[1], p_))
    spin = tensor_times(tape, tensor, w)
    rows = [tape(sp.Add(*(E[3 * i + j] * S[1][j] for j in range(3)))) for i in range(3)]
    moment = added(tape, added(tape, crossed(tape, h_, v), spin), (rows[0], rows[1], rows[2]))
    return force, moment


def _dot(tape: Tape, S: Six, F: Six) -> Expression:
    return tape(sp.Add(*(S[k][i] * F[k][i] for k in range(2) for i in range(3))))
