"""Mass matrix of the joint variables by composite rigid bodies, and its L D L^T solver.

Each joint carries everything beyond it as one body. Intermediates are named on a tape.
"""

from collections.abc import Sequence

import sympy as sp

from ..expressions.symbols import Expression
from .chain import UPPER, Matrix, Vector, added, crossed, symmetric, upper
from .program import Tape
from .recursion import Inertia, JointTransform


def _rotated(
    tape: Tape, joint: JointTransform, tensor: Sequence[Expression]
) -> tuple[Expression, ...]:
    """R I R^T from frame i to frame i - 1 axes."""
    xx, xy, xz, yy, yz, zz = tensor
    c, s = joint.cosine, joint.sine
    if joint.revolute:
        cs, cc = tape(c * s), tape(c * c)
        difference = tape(xx - yy)
        change = tape(cc * difference - 2 * cs * xy)
        new_xy = tape(cs * difference + (2 * cc - 1) * xy)
        xx, yy, xy = tape(yy + change), tape(xx - change), new_xy
        xz, yz = tape(c * xz - s * yz), tape(s * xz + c * yz)
    R = joint.segment.rotation
    half = (R * symmetric((xx, xy, xz, yy, yz, zz))).applyfunc(tape)
    return tuple(map(tape, upper(half * R.T)))


def _shifted(tape: Tape, inertia: Inertia, r: Vector) -> Inertia:
    """Inertia about an origin from which the old one lies at r."""
    h, m = inertia.moment, inertia.mass
    x, y, z = moment = [tape(h[i] + m * r[i]) for i in range(3)]
    between = tuple(tape(h[i] + moment[i]) for i in range(3))  # 2 h + m r
    products = [[tape(r[i] * between[j]) for j in range(3)] for i in range(3)]
    tensor = []
    for old, (i, j) in zip(inertia.tensor, UPPER, strict=True):
        if i == j:
            k, n = [axis for axis in range(3) if axis != i]
            tensor.append(tape(old + products[k][k] + products[n][n]))
        else:
            tensor.append(tape(old - r[i] * moment[j] - h[i] * r[j]))
    return Inertia(m, (x, y, z), tuple(tensor))


def joint_mass_matrix(tape: Tape, chain: Sequence[JointTransform]) -> Matrix:
    """D_theta, n x n, by the composite-rigid-body algorithm."""
    n = len(chain)
    D: Matrix = [[sp.S.Zero] * n for _ in range(n)]
    composite = chain[-1].segment.inertia
    for j in reversed(range(n)):
        if j < n - 1:
            outer = chain[j + 1]
            h = outer.out(tape, composite.moment)
            moved = Inertia(composite.mass, h, _rotated(tape, outer, composite.tensor))
            moved = _shifted(tape, moved, outer.translation)
            pairs = zip(chain[j].segment.inertia.elements, moved.elements, strict=True)
            m, x, y, z, *tensor = (tape(u + v) for u, v in pairs)
            composite = Inertia(m, (x, y, z), tuple(tensor))
        force, moment = _momentum(composite, chain[j])
        D[j][j] = moment[2] if chain[j].revolute else force[2]
        for i in reversed(range(j)):
            joint = chain[i + 1]
            force, moment = joint.out(tape, force), joint.out(tape, moment)
            moment = added(tape, moment, crossed(tape, joint.translation, force))
            D[i][j] = D[j][i] = moment[2] if chain[i].revolute else force[2]
    return D


def _momentum(inertia: Inertia, joint: JointTransform) -> tuple[Vector, Vector]:
    """Linear and angular momentum of a body at unit rate of its joint."""
    h, tensor, zero = inertia.moment, inertia.tensor, sp.S.Zero
    if joint.revolute:
        return (-h[1], h[0], zero), (tensor[2], tensor[4], tensor[5])
    return (zero, zero, inertia.mass), (h[1], -h[0], zero)


def solved(tape: Tape, D: Matrix, right: Sequence[Expression]) -> list[Expression]:
    """D^-1 right for a positive definite D, by the factors L diag L^T."""
    n = len(right)
    L: Matrix = [[sp.S.Zero] * n for _ in range(n)]
    pivot: list[Expression] = []
    for j in range(n):
        carried = [tape(L[j][k] * pivot[k]) for k in range(j)]
        pivot.append(tape(D[j][j] - sp.Add(*(L[j][k] * carried[k] for k in range(j)))))
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
