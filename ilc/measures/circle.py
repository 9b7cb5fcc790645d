"""Least-squares circle through points of a plane, compiled."""

import numpy as np
from numba import njit

from armside.arrays import Array

STRAIGHT = 1e-12
"""Variance ratio, across over along, below which points count as collinear."""


@njit(cache=True, nogil=True, error_model="numpy")
def newton(points: Array) -> tuple[Array, bool]:  # pragma: no cover - compiled
    """Centre (2,) that minimises the squared radial distances of points (M, 2) with mean zero.

    Newton's method on f = sum (r_i - R)^2 / 2, the radius R = mean of r_i eliminated: r_i has the
    gradient -d_i, d_i the direction of the point, and the second derivative (I - d_i d_i') / r_i.
    False, and no centre, if the points lie on one line.
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
    # Start: the algebraic fit, x^2 + y^2 = 2 c.x + const, which is linear in c.
    centre[0] = 0.5 * (yy * xz - xy * yz) / determinant
    centre[1] = 0.5 * (xx * yz - xy * xz) / determinant
    radii, directions = np.empty(n), np.empty((n, 2))
    for _ in range(20):
        mean = mean_x = mean_y = 0.0
        for i in range(n):
            x, y = points[i, 0] - centre[0], points[i, 1] - centre[1]
            radii[i] = np.sqrt(x * x + y * y)
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
        if np.hypot(step_x, step_y) <= 1e-12 * mean:
            break
    return centre, True
