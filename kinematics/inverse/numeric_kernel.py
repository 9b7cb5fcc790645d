"""Numeric inverse kinematics of any serial robot: the compiled part.

`cache` compiles a copy of this file in the cache folder; `numeric` holds the interface and the
meaning of the arguments. A robot is data here, so one compiled module serves all: `links` has
theta, d, a, cos alpha, sin alpha of each standard link, `joints` its type (0 revolute, 1 prismatic,
2 fixed), and joint variables are M phi + offset. A target is T (4, 4); with `rows` 3 only its
position counts. The error of a configuration is the six-vector (translation, rotation vector) in
base axes that takes the tool to the target. Steps are damped least squares, the damping
proportional to the square of the error (T. Sugihara, IEEE Trans. Robotics 27, 2011). Near a
singularity such a descent creeps along a curved valley, which a few undamped steps leave.
"""

from math import atan2, cos, floor, pi, sin, sqrt

import numpy as np
from numba import njit

EXACT = 1e-12  # [m] and [rad], error that is not reduced further
STEPS = 60  # greatest number of steps from one start
NEAR = 1e-6  # square of the error below which undamped steps are tried
LEAP = 10  # greatest number of these until the error is less than before
STALLED = 1e4  # damping at which a descent is given up: steps of 0.1 mm for an error of 1 m
GAIN, LEAST_GAIN, FLOOR = 0.1, 1e-4, 1e-15  # damping = gain * squared error + floor
ORTHOGONAL = 1e-6  # sum of the deviations of a rotation matrix that is accepted
SLACK = 1e-9  # [rad] or [m] beyond a limit that counts as rounding
TURN = 2.0 * pi
JUMP = pi / 2.0  # [rad] from one target of a path to the next that is another branch

FOUND, OPEN, OUTSIDE = 0, 1, 2
"""Outcomes of a target: solved, an error remains, solved only beyond the limits."""


@njit(cache=True, error_model="numpy")
def _error(T, target, rows, e):
    """Fill e (6,) with the error; returns its square over the rows that count."""
    for i in range(3):
        e[i] = target[i, 3] - T[i, 3]
    square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2]
    if rows == 3:
        return square
    # D = target T^T; its antisymmetric part is sin(angle) axis, its trace 1 + 2 cos(angle).
    d00 = target[0, 0] * T[0, 0] + target[0, 1] * T[0, 1] + target[0, 2] * T[0, 2]
    d01 = target[0, 0] * T[1, 0] + target[0, 1] * T[1, 1] + target[0, 2] * T[1, 2]
    d02 = target[0, 0] * T[2, 0] + target[0, 1] * T[2, 1] + target[0, 2] * T[2, 2]
    d10 = target[1, 0] * T[0, 0] + target[1, 1] * T[0, 1] + target[1, 2] * T[0, 2]
    d11 = target[1, 0] * T[1, 0] + target[1, 1] * T[1, 1] + target[1, 2] * T[1, 2]
    d12 = target[1, 0] * T[2, 0] + target[1, 1] * T[2, 1] + target[1, 2] * T[2, 2]
    d20 = target[2, 0] * T[0, 0] + target[2, 1] * T[0, 1] + target[2, 2] * T[0, 2]
    d21 = target[2, 0] * T[1, 0] + target[2, 1] * T[1, 1] + target[2, 2] * T[1, 2]
    d22 = target[2, 0] * T[2, 0] + target[2, 1] * T[2, 1] + target[2, 2] * T[2, 2]
    x, y, z = (d21 - d12) / 2.0, (d02 - d20) / 2.0, (d10 - d01) / 2.0
    sine, cosine = sqrt(x * x + y * y + z * z), (d00 + d11 + d22 - 1.0) / 2.0
    angle = atan2(sine, cosine)
    if sine > 1e-6 or cosine > 0.0:
        factor = angle / sine if sine > 0.0 else 1.0
        e[3], e[4], e[5] = factor * x, factor * y, factor * z
    else:  # half a turn: the axis is the greatest column of D + 1
        if d00 >= d11 and d00 >= d22:
            x, y, z = d00 + 1.0, d10, d20
        elif d11 >= d22:
            x, y, z = d01, d11 + 1.0, d21
        else:
            x, y, z = d02, d12, d22 + 1.0
        factor = angle / sqrt(x * x + y * y + z * z)
        e[3], e[4], e[5] = factor * x, factor * y, factor * z
    return square + e[3] * e[3] + e[4] * e[4] + e[5] * e[5]


@njit(cache=True, error_model="numpy")
def _solve(A, x, n):
    """Solve A x = b in place for positive definite A (n, n), b given in x. False if it is not."""
    for j in range(n):
        pivot = A[j, j]
        for k in range(j):
            pivot -= A[j, k] * A[j, k]
        if not pivot > 0.0:
            return False
        pivot = sqrt(pivot)
        A[j, j] = pivot
        for i in range(j + 1, n):
            value = A[i, j]
            for k in range(j):
                value -= A[i, k] * A[j, k]
            A[i, j] = value / pivot
    for i in range(n):
        for k in range(i):
            x[i] -= A[i, k] * x[k]
        x[i] /= A[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= A[k, i] * x[k]
        x[i] /= A[i, i]
    return True


@njit(cache=True, error_model="numpy")
def _step(J, e, damping, rows, n, A, x, step):
    """Fill step (n,) with the damped least-squares step J^T (J J^T + damping)^-1 e, or its equal
    (J^T J + damping)^-1 J^T e where that is the smaller system."""
    if rows <= n:
        for i in range(rows):
            for j in range(i + 1):
                total = 0.0
                for k in range(n):
                    total += J[i, k] * J[j, k]
                A[i, j] = total
            A[i, i] += damping
            x[i] = e[i]
        if not _solve(A, x, rows):
            return False
        for k in range(n):
            total = 0.0
            for i in range(rows):
                total += J[i, k] * x[i]
            step[k] = total
        return True
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(rows):
                total += J[k, i] * J[k, j]
            A[i, j] = total
        A[i, i] += damping
        step[i] = 0.0
        for k in range(rows):
            step[i] += J[k, i] * e[k]
    return _solve(A, step, n)


@njit(cache=True, error_model="numpy")
def _forward(links, joints, M, offset, phi, axes, T):
    """Fill T (4, 4) and axes (n, 6): direction of each joint axis and a point of it, base axes."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    px, py, pz = 0.0, 0.0, 0.0
    joint = 0
    for i in range(links.shape[0]):
        theta, d, a, ca, sa = links[i, 0], links[i, 1], links[i, 2], links[i, 3], links[i, 4]
        if joints[i] != 2:
            axes[joint, 0], axes[joint, 1], axes[joint, 2] = zx, zy, zz
            axes[joint, 3], axes[joint, 4], axes[joint, 5] = px, py, pz
            value = offset[joint]
            for k in range(M.shape[0]):
                value += M[joint, k] * phi[k]
            if joints[i] == 0:
                theta += value
            else:
                d += value
            joint += 1
        c, s = cos(theta), sin(theta)
        nx, ny, nz = c * xx + s * yx, c * xy + s * yy, c * xz + s * yz
        ox, oy, oz = c * yx - s * xx, c * yy - s * xy, c * yz - s * xz
        px, py, pz = px + d * zx + a * nx, py + d * zy + a * ny, pz + d * zz + a * nz
        xx, xy, xz = nx, ny, nz
        yx, yy, yz = ca * ox + sa * zx, ca * oy + sa * zy, ca * oz + sa * zz
        zx, zy, zz = ca * zx - sa * ox, ca * zy - sa * oy, ca * zz - sa * oz
    T[0, 0], T[0, 1], T[0, 2], T[0, 3] = xx, yx, zx, px
    T[1, 0], T[1, 1], T[1, 2], T[1, 3] = xy, yy, zy, py
    T[2, 0], T[2, 1], T[2, 2], T[2, 3] = xz, yz, zz, pz


@njit(cache=True, error_model="numpy")
def _jacobian(prismatic, M, coupled, axes, T, columns, lower, upper, J):
    """Fill J (6, n), (v, omega) of the tool from motor rates, from what `_forward` filled.

    Motors whose bounds coincide are left out.
    """
    n = M.shape[0]
    target = columns if coupled else J
    for i in range(n):
        zx, zy, zz = axes[i, 0], axes[i, 1], axes[i, 2]
        if prismatic[i]:
            target[0, i], target[1, i], target[2, i] = zx, zy, zz
            target[3, i], target[4, i], target[5, i] = 0.0, 0.0, 0.0
        else:
            rx, ry, rz = T[0, 3] - axes[i, 3], T[1, 3] - axes[i, 4], T[2, 3] - axes[i, 5]
            target[0, i], target[1, i] = zy * rz - zz * ry, zz * rx - zx * rz
            target[2, i] = zx * ry - zy * rx
            target[3, i], target[4, i], target[5, i] = zx, zy, zz
    if coupled:
        for i in range(6):
            for j in range(n):
                total = 0.0
                for k in range(n):
                    total += columns[i, k] * M[k, j]
                J[i, j] = total
    for j in range(n):
        if lower[j] == upper[j]:
            for i in range(6):
                J[i, j] = 0.0


@njit(cache=True, error_model="numpy")
def _move(robot, target, rows, lower, upper, phi, work):
    """Fill trial (n,) with phi and the step, within the bounds; e with its error. The square."""
    links, joints, _, M, offset, _ = robot
    axes, T, _, _, _, _, step, trial, e = work
    for i in range(phi.shape[0]):
        trial[i] = min(max(phi[i] + step[i], lower[i]), upper[i])
    _forward(links, joints, M, offset, trial, axes, T)
    return _error(T, target, rows, e)


@njit(cache=True, error_model="numpy")
def _leap(robot, target, rows, lower, upper, phi, error, start, work):
    """As `_move`, by undamped steps until the square is below the start's; J is that of phi."""
    _, _, prismatic, M, _, coupled = robot
    axes, T, J, columns, A, x, step, trial, e = work
    n, square = phi.shape[0], start
    for i in range(n):
        trial[i] = phi[i]
    for i in range(6):
        e[i] = error[i]
    for k in range(LEAP):
        if k > 0:
            _jacobian(prismatic, M, coupled, axes, T, columns, lower, upper, J)
        if not _step(J, e, FLOOR, rows, n, A, x, step):
            return start
        square = _move(robot, target, rows, lower, upper, trial, work)
        if square < start:
            break
    return square


@njit(cache=True, error_model="numpy")
def _descend(robot, target, rows, lower, upper, phi, error, work):
    """Steps from phi (n,) until its error is exact, stalls or STEPS are done; fills phi and error.

    Returns the square of the error. Steps end at the bounds lower and upper (n,).
    """
    links, joints, prismatic, M, offset, coupled = robot
    axes, T, J, columns, A, x, step, trial, e = work
    n = phi.shape[0]
    _forward(links, joints, M, offset, phi, axes, T)
    square, gain, moved, leaps = _error(T, target, rows, error), GAIN, True, True
    for _ in range(STEPS):
        if square < EXACT * EXACT:
            break
        if moved:
            _jacobian(prismatic, M, coupled, axes, T, columns, lower, upper, J)
        if not _step(J, error, gain * square + FLOOR, rows, n, A, x, step):
            break
        new = _move(robot, target, rows, lower, upper, phi, work)
        moved = new < square
        if not moved and leaps and square < NEAR:
            new = _leap(robot, target, rows, lower, upper, phi, error, square, work)
            leaps = moved = new < square
            if not moved:  # J of phi again
                _forward(links, joints, M, offset, phi, axes, T)
                _jacobian(prismatic, M, coupled, axes, T, columns, lower, upper, J)
        if moved:
            square, gain = new, max(0.25 * gain, LEAST_GAIN)
            for i in range(n):
                phi[i] = trial[i]
            for i in range(6):
                error[i] = e[i]
        else:
            gain *= 8.0
            if gain * square > STALLED or square < 1e-20:
                break
    return square


@njit(cache=True, error_model="numpy")
def _work(n):
    """Memory of `_descend` for n joints."""
    axes, T, J, columns = np.empty((n, 6)), np.empty((4, 4)), np.empty((6, n)), np.empty((6, n))
    x, step, trial, e = np.empty(6), np.empty(n), np.empty(n), np.empty(6)
    return axes, T, J, columns, np.empty((6, 6)), x, step, trial, e


@njit(cache=True, error_model="numpy")
def _unwind(robot, turns, phi, start, lower, upper):
    """Turn revolute joints by whole turns: nearest to the start, then into the limits.

    A start beyond the limits counts as the limit itself, whence one turn leads to any solution.
    """
    _, _, prismatic, M, _, _ = robot
    n = phi.shape[0]
    for j in range(n):
        if prismatic[j]:
            continue
        away = 0.0
        for k in range(n):
            away += M[j, k] * (phi[k] - min(max(start[k], lower[k]), upper[k]))
        count = -floor(away / TURN + 0.5)
        if phi[j] + TURN * count * turns[j, j] < lower[j] - SLACK:
            count += 1.0
        elif phi[j] + TURN * count * turns[j, j] > upper[j] + SLACK:
            count -= 1.0
        for k in range(n):
            phi[k] += TURN * count * turns[k, j]


@njit(cache=True, error_model="numpy")
def _within(phi, lower, upper, combinations, least, most):
    """True if phi and its linear combinations are in their ranges."""
    for i in range(phi.shape[0]):
        if not lower[i] - SLACK <= phi[i] <= upper[i] + SLACK:
            return False
    for i in range(combinations.shape[0]):
        value = 0.0
        for k in range(phi.shape[0]):
            value += combinations[i, k] * phi[k]
        if not least[i] - SLACK <= value <= most[i] + SLACK:
            return False
    return True


@njit(cache=True, error_model="numpy")
def _is_solved(error, rows, tolerance):
    for i in range(rows):  # noqa: SIM110 - a generator is slow in compiled code
        if not abs(error[i]) <= tolerance:
            return False
    return True


@njit("b1(f8[:,:,::1])", cache=True, error_model="numpy", nogil=True)
def are_rigid(T):
    """True if all T (N, 4, 4) are rigid motions, to ORTHOGONAL."""
    for k in range(T.shape[0]):
        R = T[k]
        x0, x1, x2 = R[0, 0], R[1, 0], R[2, 0]
        y0, y1, y2 = R[0, 1], R[1, 1], R[2, 1]
        cross = x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0
        gap = abs(x0 * x0 + x1 * x1 + x2 * x2 - 1.0) + abs(y0 * y0 + y1 * y1 + y2 * y2 - 1.0)
        gap += abs(x0 * y0 + x1 * y1 + x2 * y2) + abs(R[3, 0]) + abs(R[3, 1]) + abs(R[3, 2])
        gap += abs(R[3, 3] - 1.0)
        for i in range(3):
            gap += abs(R[i, 2] - cross[i])
        if not (gap <= ORTHOGONAL and abs(R[0, 3]) + abs(R[1, 3]) + abs(R[2, 3]) < np.inf):
            return False
    return True


_ROBOT = "Tuple((f8[:,::1], i8[::1], b1[::1], f8[:,::1], f8[::1], b1))"
_RANGES = "Tuple((f8[::1], f8[::1], f8[:,::1], f8[::1], f8[::1]))"


@njit(
    f"void({_ROBOT}, f8[:,::1], f8[:,:,::1], i8, f8[:,::1], {_RANGES}, f8, b1, f8[:,::1], "
    "f8[:,::1], i8[::1])",
    cache=True,
    error_model="numpy",
    nogil=True,
)
def search(robot, turns, targets, rows, starts, ranges, tolerance, nearest, phi, error, outcome):
    """A solution for each target (N, 4, 4) from the first of the starts (m, n) that leads to one.

    With `nearest` all starts are tried, and the solution nearest to the first start is taken. Fills
    phi (N, n), error (N, 6) and outcome (N,); where none is found, the configuration with the
    least error, or the last that is solved beyond the limits.
    """
    lower, upper, combinations, least, most = ranges
    prismatic, n = robot[2], starts.shape[1]
    low, high = np.full(n, -np.inf), np.full(n, np.inf)  # revolute joints are unwound at the end
    for i in range(n):
        if prismatic[i]:
            low[i], high[i] = lower[i], upper[i]
    work, trial, e = _work(n), np.empty(n), np.empty(6)
    for k in range(targets.shape[0]):
        outcome[k] = OPEN
        best, closest = np.inf, np.inf
        for m in range(starts.shape[0]):
            trial[:] = starts[m]
            square = _descend(robot, targets[k], rows, low, high, trial, e, work)
            solved = _is_solved(e, rows, tolerance)
            inside = False
            if solved:
                _unwind(robot, turns, trial, starts[0], lower, upper)
                inside = _within(trial, lower, upper, combinations, least, most)
            if inside:
                distance = 0.0
                for i in range(n):
                    distance += (trial[i] - starts[0, i]) ** 2
                if distance < closest:
                    closest, outcome[k] = distance, FOUND
                    phi[k], error[k] = trial, e
                if not nearest:
                    break
            elif outcome[k] == OPEN and (solved or square < best):
                best = square
                if solved:
                    outcome[k] = OUTSIDE
                phi[k], error[k] = trial, e


@njit(cache=True, error_model="numpy")
def _most_beyond(phi, lower, upper):
    """The motor that is furthest beyond its range; -1 if all are within."""
    worst, furthest = -1, SLACK
    for i in range(phi.shape[0]):
        beyond = max(phi[i] - upper[i], lower[i] - phi[i])
        if beyond > furthest:
            worst, furthest = i, beyond
    return worst


@njit(cache=True, error_model="numpy")
def _within_ranges(robot, target, rows, ranges, tolerance, before, phi, error, low, high, work):
    """Solve a target from `before` (n,), with motors held at the limits that they would pass.

    True if that succeeds. Otherwise phi and error are those of the motion without limits.
    """
    lower, upper, combinations, least, most = ranges
    n = phi.shape[0]
    low[:], high[:] = -np.inf, np.inf
    free, remains = np.empty(n), np.empty(6)
    for attempt in range(n):
        phi[:] = before
        for i in range(n):
            if low[i] == high[i]:
                phi[i] = low[i]
        _descend(robot, target, rows, low, high, phi, error, work)
        if attempt == 0:
            free[:], remains[:] = phi, error
        if not _is_solved(error, rows, tolerance):
            break
        if _within(phi, lower, upper, combinations, least, most):
            return True
        worst = _most_beyond(phi, lower, upper)
        if worst < 0 or low[worst] == high[worst]:
            break
        bound = upper[worst] if phi[worst] > upper[worst] else lower[worst]
        low[worst] = high[worst] = bound
    phi[:], error[:] = free, remains
    return False


@njit(cache=True, error_model="numpy")
def _jumps(robot, before, phi):
    """True if a revolute joint turns by JUMP or more."""
    _, _, prismatic, M, _, _ = robot
    for j in range(phi.shape[0]):
        turn = 0.0
        for k in range(phi.shape[0]):
            turn += M[j, k] * (phi[k] - before[k])
        if not prismatic[j] and abs(turn) >= JUMP:
            return True
    return False


@njit(
    f"i8({_ROBOT}, f8[:,:,::1], i8, {_RANGES}, f8, f8[:,::1], f8[::1])",
    cache=True,
    error_model="numpy",
    nogil=True,
)
def follow(robot, targets, rows, ranges, tolerance, path, error):
    """Solutions of targets 1.. into path (N, n), each from the one before; path[0] is given.

    Returns the number of targets that are solved within the ranges, without a jump; of the first
    that is not, path and error (6,) have the configuration.
    """
    n = path.shape[1]
    low, high, work = np.empty(n), np.empty(n), _work(n)
    for k in range(1, targets.shape[0]):
        before, phi = path[k - 1], path[k]
        if not _within_ranges(
            robot, targets[k], rows, ranges, tolerance, before, phi, error, low, high, work
        ):
            return k
        if _jumps(robot, before, phi):
            return k
    return targets.shape[0]
