"""Branches of an arm whose axes 2, 3 and 4 are parallel: the compiled part.

`kernel` calls `branches`. Angles are D-H angles theta, turned so that a2 and a3 are positive. The
geometry `g` is (d1, a1, sin alpha1, cos alpha1, a2, a3, r, beta, h, sigma, tau, side, s). The wrist
centre is where axes 5 and 6 meet; h is its offset along axis 2. In the plane of the arm, whose x is
that of frame 1, axis 4 is at a2 in direction theta2 plus a3 in direction theta2 + sigma theta3, and
the wrist centre at r in direction Phi + beta from there, Phi = theta2 + sigma theta3 + tau theta4.
sigma and tau are +-1 where axes 3 and 4 point along axis 2 or against it, side is tau sin alpha4,
s is sin alpha5. The order is theta1 from h, theta5, Phi and theta6 from the rotation, then the
triangle of theta2 and theta3.
"""

from math import atan2, cos, hypot, pi, sin, sqrt

from numba import njit

TOUCHING = 2e-11  # [m], distance outside the reach that counts as rounding
ALIGNED = 2e-11  # sine, or [m], below which a free angle takes its reference value
ROUNDED = 1e-14  # turn of axis 6 [rad] that counts as rounding
STRETCHED = 1e-7  # sine of the elbow, or [m] from the shoulder's singularity; rounding of
# 1e-16 m at the edge of the reach, or of the offset, makes it 1e-8

SHOULDER, ELBOW, WRIST = 1, 2, 4


@njit(cache=True, error_model="numpy")
def _outside(X, Y, least, most):
    """Distance [m] of a point of the plane from the ring that axis 4 reaches; negative inside."""
    D = hypot(X, Y)
    return max(D - most, least - D)


@njit(cache=True, error_model="numpy")
def _nearest_in_reach(X, Y, r, bearing, least, most):
    """Direction nearest to `bearing` in which r leads from the ring to the wrist centre (X, Y).

    The direction itself where no other is in reach.
    """
    D, away = hypot(X, Y), atan2(Y, X)
    best, nearest = bearing, 1e300
    for edge in (least, most):  # the triangle of D, r and the edge
        if D * r > 0.0 and abs(D - r) <= edge <= D + r:
            cosine = (D * D + r * r - edge * edge) / (2.0 * D * r)
            angle = atan2(sqrt(max(1.0 - cosine * cosine, 0.0)), cosine)
            for side in (-angle, angle):
                turn = away + side - bearing
                turn -= 2.0 * pi * round(turn / (2.0 * pi))
                if abs(turn) < nearest:
                    best, nearest = bearing + turn, abs(turn)
    return best


@njit(cache=True, error_model="numpy")
def _elbows(X, Y, Phi, g, reference, theta, flags, flag):
    """theta2, theta3, theta4 of both elbow branches, rows 0 and 2, for axis 4 at (X, Y).

    Returns the distance [m] of axis 4 outside its reach, not above 0 where it is inside.
    """
    a2, a3, sigma, tau = g[4], g[5], g[9], g[10]
    gap = _outside(X, Y, abs(a2 - a3), a2 + a3)
    if gap > TOUCHING:
        return gap
    D = hypot(X, Y)
    cosine = (D * D - a2 * a2 - a3 * a3) / (2.0 * a2 * a3)
    area = max(D - abs(a2 - a3), 0.0) * (D + abs(a2 - a3))
    area *= max(a2 + a3 - D, 0.0) * (a2 + a3 + D)
    sine = sqrt(area) / (2.0 * a2 * a3)
    gamma = atan2(sine, cosine)
    inner = atan2(a3 * sine, a2 + a3 * cosine)
    centre = reference[1] if D < ALIGNED else atan2(Y, X)
    if sine < STRETCHED:
        flag |= ELBOW
    for elbow in range(2):
        bend = 1.0 if elbow == 0 else -1.0
        th2 = centre - bend * inner
        row = theta[2 * elbow]
        row[1], row[2] = th2, sigma * bend * gamma
        row[3] = tau * (Phi - th2 - bend * gamma)
        flags[2 * elbow] = flag
    return 0.0


@njit(cache=True, error_model="numpy")
def _shoulder(W, th1, X, Y, g, reference, theta, flags, flag):
    """The four branches of a theta1, for the wrist centre at (X, Y) in the plane of the arm.

    Returns the distance [m] of axis 4 outside its reach, 0 where a branch exists.
    """
    sa, ca, r, beta, side, s = g[2], g[3], g[6], g[7], g[11], g[12]
    c1, s1 = cos(th1), sin(th1)
    # Columns x, y, z of the wrist's rotation along x and y of the arm's plane, and axis 2.
    xx, xy = c1 * W[0, 0] + s1 * W[1, 0], ca * (c1 * W[1, 0] - s1 * W[0, 0]) + sa * W[2, 0]
    yx, yy = c1 * W[0, 1] + s1 * W[1, 1], ca * (c1 * W[1, 1] - s1 * W[0, 1]) + sa * W[2, 1]
    zx, zy = c1 * W[0, 2] + s1 * W[1, 2], ca * (c1 * W[1, 2] - s1 * W[0, 2]) + sa * W[2, 2]
    zz = sa * (s1 * W[0, 2] - c1 * W[1, 2]) + ca * W[2, 2]
    sine = hypot(zx, zy)
    th5 = atan2(sine, -s * side * zz)
    aligned = sine < ALIGNED
    least, most = abs(g[4] - g[5]), g[4] + g[5]
    if aligned:  # only a combination of Phi and theta6 is determined: theta6 keeps its reference
        flag |= WRIST
        c6, s6 = cos(reference[5]), sin(reference[5])
        Phi = atan2(s * side * (s6 * xx + c6 * yx), -s * side * (s6 * xy + c6 * yy))
        v = Phi + beta
        if _outside(X - r * cos(v), Y - r * sin(v), least, most) > 0.0:
            Phi = _nearest_in_reach(X, Y, r, v, least, most) - beta
    else:
        Phi = atan2(s * zy, s * zx)
    outside = 1e300
    for flipped in range(2):
        turn = pi if flipped == 1 and not aligned else 0.0
        v, rounding = Phi + turn + beta, 0.0
        if not aligned and _outside(X - r * cos(v), Y - r * sin(v), least, most) > 0.0:
            # A rounding of axis 6 turns Phi by 1 / sine as much, which may be out of the reach.
            rounding = _nearest_in_reach(X, Y, r, v, least, most) - v
            if abs(rounding) * sine > ROUNDED:
                rounding = 0.0
        v += rounding
        cp, sp = cos(Phi + rounding), sin(Phi + rounding)
        # theta6 from the rest of the rotation, so that a rounding of Phi is compensated
        th6 = atan2(s * side * (sp * xx - cp * xy), s * side * (sp * yx - cp * yy))
        x, y = X - r * cos(v), Y - r * sin(v)
        rows = theta[flipped:]
        gap = _elbows(x, y, Phi + rounding + turn, g, reference, rows, flags[flipped:], flag)
        outside = min(outside, gap)
        for elbow in range(2):
            row = rows[2 * elbow]
            row[0], row[4], row[5] = th1, (-th5 if turn > 0.0 else th5), th6 + turn
    return outside


@njit(cache=True, error_model="numpy")
def branches(W, g, reference, theta, flags):
    """All eight branches of W = T from base axes to just after Rot_z(theta6).

    Fills theta (8, 6) and flags (8,), -1 where a branch does not exist. Returns the distance [m]
    of the wrist centre outside the reach, 0 where it is inside.
    """
    d1, a1, sa, ca, h = g[0], g[1], g[2], g[3], g[8]
    x, y, z = W[0, 3], W[1, 3], W[2, 3] - d1
    for b in range(8):
        flags[b] = -1
    rho = hypot(x, y)
    k = (h - ca * z) / sa
    if abs(k) > rho + TOUCHING:
        return abs(k) - rho
    along = sqrt(max(rho - abs(k), 0.0) * (rho + abs(k)))
    at_shoulder = rho < ALIGNED
    flag = SHOULDER if at_shoulder or along < STRETCHED else 0
    outside = 1e300
    for shoulder in range(2):
        forward = along if shoulder == 0 else -along
        th1 = reference[0] if at_shoulder else atan2(y, x) + atan2(k, forward)
        X, Y = forward - a1, -ca * k + sa * z
        rows = theta[4 * shoulder : 4 * shoulder + 4]
        found = flags[4 * shoulder : 4 * shoulder + 4]
        outside = min(outside, _shoulder(W, th1, X, Y, g, reference, rows, found, flag))
    return outside
