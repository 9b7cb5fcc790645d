"""Least-squares circle through points of a plane, compiled.

f(c) = sum (r_i - R)^2 / 2 with R the mean of the distances r_i from c. On arcs it has several local
minima and saddle points: Newton's method is quick from the algebraic centre, and descents from
other starts make sure of the smallest.
"""

import numpy as np
from numba import njit

from armside.arrays import Array

STRAIGHT = 1e-12
"""Variance ratio, across over along, below which points count as collinear."""
FARTHEST = 1e4
"""Distance of a centre over the spread of the points above which they count as collinear."""
_STEPS = 20
_DESCENTS = 200
_CONVERGED = 1e-12
_STIFFEST = 1e12  # damping of a descent's step at which there is none downwards
_NEAR = 1e-4  # step of a descent, relative to the radius, that Newton's method takes up
_ASIDE = 1e-3  # of the radius, by which a start is moved off a point
_BETTER = 1.0 - 1e-9  # a smaller f, beyond rounding


@njit(cache=True, nogil=True, error_model="numpy")
def least_squares(points: Array) -> tuple[Array, bool]:  # pragma: no cover - compiled
    """Centre (2,) that minimises the squared radial distances of points (M, 2) with mean zero.

    False, and no centre, if the points lie on one line, or nearer to one than to any circle.
    """
    start, found = algebraic(points)
    if not found:
        return start, False
    best, smallest = start, np.inf
    centre, minimum = newton(points, start)
    if minimum:
        best, smallest = centre, cost(points, centre)
    for sign in (1.0, -1.0, 0.0):
        centre = descent(points, sign * start)
        polished, minimum = newton(points, centre)
        if minimum and cost(points, polished) <= cost(points, centre):
            centre = polished
        value = cost(points, centre)
        if value < _BETTER * smallest:
            best, smallest = centre, value
    spread = np.sqrt((points**2).sum() / len(points))
    return best, np.hypot(best[0], best[1]) <= FARTHEST * spread


@njit(cache=True, nogil=True, error_model="numpy")
def cost(points: Array, centre: Array) -> float:  # pragma: no cover - compiled
    """f at a centre."""
    radii = np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1])
    return float(0.5 * ((radii - radii.mean()) ** 2).sum())


@njit(cache=True, nogil=True, error_model="numpy")
def descent(points: Array, start: Array) -> Array:  # pragma: no cover - compiled
    """Centre (2,) of a local minimum, by Levenberg and Marquardt's method.

    f has a kink in each point, where its distance has no gradient: a start there is moved.
    """
    n, centre = len(points), start.copy()
    radii = np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1])
    if radii.min() == 0.0:
        centre[0] += _ASIDE * radii.mean()
    value, damping = cost(points, centre), 1e-3
    for _ in range(_DESCENTS):
        away = points - centre
        radii = np.hypot(away[:, 0], away[:, 1])
        residual = radii - radii.mean()
        directions = away / np.maximum(radii, 1e-300).reshape(n, 1)
        sx = directions[:, 0] - directions[:, 0].mean()
        sy = directions[:, 1] - directions[:, 1].mean()
        hxx, hxy, hyy = (sx * sx).sum(), (sx * sy).sum(), (sy * sy).sum()
        gx, gy = (sx * residual).sum(), (sy * residual).sum()
        step, there = np.zeros(2), value
        while damping < _STIFFEST:
            a, d = hxx * (1.0 + damping) + 1e-300, hyy * (1.0 + damping) + 1e-300
            determinant = a * d - hxy * hxy
            step = np.array([(d * gx - hxy * gy) / determinant, (a * gy - hxy * gx) / determinant])
            there = cost(points, centre + step)
            if there < value:
                break
            damping *= 10.0
        if not there < value:
            break
        centre, value, damping = centre + step, there, 0.1 * damping
        if np.hypot(step[0], step[1]) <= _NEAR * radii.mean():
            break
    return centre


@njit(cache=True, nogil=True, error_model="numpy")
def algebraic(points: Array) -> tuple[Array, bool]:  # pragma: no cover - compiled
    """Centre (2,) of the algebraic fit, x^2 + y^2 = 2 c.x + const, which is linear in c.

    points: (M, 2), with mean zero. False, and no centre, if they lie on one line.
    """
    n = len(points)
    xx = xy = yy = xz = yz = 0.0
    for i in range(n):
        x, y = points[i]
        z = x * x + y * y
        xx += x * x
        xy += x * y
        yy += y * y
        xz += x * z
        yz += y * z
    determinant = xx * yy - xy * xy
    centre = np.zeros(2)
    if not determinant > STRAIGHT * (xx + yy) ** 2:
        return centre, False
    centre[0] = 0.5 * (yy * xz - xy * yz) / determinant
    centre[1] = 0.5 * (xx * yz - xy * xz) / determinant
    return centre, True


@njit(cache=True, nogil=True, error_model="numpy")
def newton(points: Array, start: Array) -> tuple[Array, bool]:  # pragma: no cover - compiled
    """Centre (2,) by Newton's method, and True if it is a local minimum.

    r_i has the gradient -d_i, d_i the direction of the point, and the second derivative
    (I - d_i d_i') / r_i.
    """
    n, centre = len(points), start.copy()
    radii, directions = np.empty(n), np.empty((n, 2))
    for _ in range(_STEPS):
        mean = mean_x = mean_y = 0.0
        for i in range(n):
            x, y = points[i, 0] - centre[0], points[i, 1] - centre[1]
            radii[i] = np.sqrt(x * x + y * y)
            if radii[i] == 0.0:
                return centre, False
            directions[i, 0], directions[i, 1] = x / radii[i], y / radii[i]
            mean += radii[i] / n
            mean_x += directions[i, 0] / n
            mean_y += directions[i, 1] / n
        hxx = hxy = hyy = gx = gy = 0.0
        for i in range(n):
            dx, dy = directions[i]
            sx, sy = dx - mean_x, dy - mean_y
            tangential = 1.0 - mean / radii[i]
            hxx += sx * sx + tangential * dy * dy
            hxy += sx * sy - tangential * dx * dy
            hyy += sy * sy + tangential * dx * dx
            gx += sx * (radii[i] - mean)
            gy += sy * (radii[i] - mean)
        determinant = hxx * hyy - hxy * hxy
        step_x = (hyy * gx - hxy * gy) / determinant
        step_y = (hxx * gy - hxy * gx) / determinant
        centre[0] += step_x
        centre[1] += step_y
        if np.hypot(step_x, step_y) <= _CONVERGED * mean:
            return centre, determinant > 0.0 and hxx > 0.0
    return centre, False
