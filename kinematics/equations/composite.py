"""The mass matrix of joint variables by composite bodies, and a solver for it.

Each joint carries everything beyond it as one body. Intermediates are named on a tape.
"""

from collections.abc import Sequence

import sympy as sp

from ..dh import Joint
from ..expressions.exact import Expression
from .chain import Vector, added, crossed
from .program import Tape
from .recursion import Inertia, Step

Matrix = list[list[Expression]]


def _rotated(tape: Tape, step: Step, tensor: Sequence[Expression]) -> tuple[Expression, ...]:
    """R I R^T from frame i to frame i - 1 axes."""
    xx, xy, xz, yy, yz, zz = tensor
    c, s = step.cosine, step.sine
    if step.segment.joint is Joint.REVOLUTE:
        cs, cc = tape(c * s), tape(c * c)
        difference = tape(xx - yy)
        share = tape(cc * difference - 2 * cs * xy)
        new_xy = tape(cs * difference + (2 * cc - 1) * xy)
        xx, yy, xy = tape(yy + share), tape(xx - share), new_xy
        xz, yz = tape(c * xz - s * yz), tape(s * xz + c * yz)
    turn, full = step.segment.turn, sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    half = (turn * full).applyfunc(tape)
    whole = half * turn.T
    return tuple(tape(whole[i, j]) for i in range(3) for j in range(i, 3))


def _shifted(tape: Tape, inertia: Inertia, r: Vector) -> Inertia:
    """About an origin from which the old one lies at r."""
    h, m = inertia.moment, inertia.mass
    moment = tuple(tape(h[i] + m * r[i]) for i in range(3))
    between = tuple(tape(h[i] + moment[i]) for i in range(3))  # 2 h + m r
    products = [[tape(r[i] * between[j]) for j in range(3)] for i in range(3)]
    tensor = []
    for position, (i, j) in enumerate([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]):
        old = inertia.tensor[position]
        if i == j:
            k, n = [axis for axis in range(3) if axis != i]
            tensor.append(tape(old + products[k][k] + products[n][n]))
        else:
            tensor.append(tape(old - r[i] * moment[j] - h[i] * r[j]))
    return Inertia(m, (moment[0], moment[1], moment[2]), tuple(tensor))


def _sum(tape: Tape, u: Inertia, v: Inertia) -> Inertia:
    total = [tape(a + b) for a, b in zip(u.elements, v.elements, strict=True)]
    return Inertia(total[0], (total[1], total[2], total[3]), tuple(total[4:]))


def joint_mass_matrix(tape: Tape, chain: Sequence[Step]) -> Matrix:
    """D_theta by composite bodies: each joint carries everything beyond it as one body."""
    n = len(chain)
    D: Matrix = [[sp.S.Zero] * n for _ in range(n)]
    composite = chain[-1].segment.inertia
    for j in reversed(range(n)):
        if j < n - 1:
            outer = chain[j + 1]
            h = outer.out(tape, composite.moment)
            moved = Inertia(composite.mass, h, _rotated(tape, outer, composite.tensor))
            composite = _sum(tape, chain[j].segment.inertia, _shifted(tape, moved, outer.shift))
        force, moment = _momentum(composite, chain[j])
        D[j][j] = moment[2] if chain[j].segment.joint is Joint.REVOLUTE else force[2]
        for i in reversed(range(j)):
            step = chain[i + 1]
            force = step.out(tape, force)
            moment = added(tape, step.out(tape, moment), crossed(tape, step.shift, force))
            revolute = chain[i].segment.joint is Joint.REVOLUTE
            D[i][j] = D[j][i] = moment[2] if revolute else force[2]
    return D


def _momentum(inertia: Inertia, step: Step) -> tuple[Vector, Vector]:
    """Linear and angular momentum of a body at unit rate of its joint."""
    h, tensor, zero = inertia.moment, inertia.tensor, sp.S.Zero
    if step.segment.joint is Joint.REVOLUTE:
        return (-h[1], h[0], zero), (tensor[2], tensor[4], tensor[5])
    return (zero, zero, inertia.mass), (h[1], -h[0], zero)


def solved(tape: Tape, D: Matrix, right: Sequence[Expression]) -> list[Expression]:
    """D^-1 right for a positive definite D, as D = L diag L^T with named intermediates."""
    n = len(right)
    L: Matrix = [[sp.S.Zero] * n for _ in range(n)]
    pivot: list[Expression] = []
    for j in range(n):
        carried = [tape(L[j][k] * pivot[k]) for k in range(j)]
        below = [tape(D[j][j] - sp.Add(*(L[j][k] * carried[k] for k in range(j))))]
        pivot.append(below[0])
        inverse = tape(1 / pivot[j])
        for i in range(j + 1, n):
            rest = D[i][j] - sp.Add(*(L[i][k] * carried[k] for k in range(j)))
            L[i][j] = tape(tape(rest) * inverse)
    x = list(right)
    for i in range(n):
        x[i] = tape(x[i] - sp.Add(*(L[i][k] * x[k] for k in range(i))))
    for i in reversed(range(n)):
        later = sp.Add(*(L[k][i] * x[k] for k in range(i + 1, n)))
        x[i] = tape(x[i] / pivot[i] - later)
    return x
