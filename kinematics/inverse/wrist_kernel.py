"""Branches of an elbow arm with a spherical wrist: the compiled part.

`kernel` calls `branches`. Angles are full D-H angles theta. The geometry `g` is
(d1, a1, sin alpha1, cos alpha1, a2, L, beta, h, sigma, t, s, sin alpha3, cos alpha3): from the
shoulder the wrist centre is at a2 in direction theta2 plus L in direction theta2 + sigma theta3 +
beta, h is its offset along axis 2, sigma is cos alpha2, t and s are the sines of alpha4, alpha5.
"""

from math import atan2, cos, hypot, pi, sin, sqrt

from numba import njit

TOUCHING = 1e-10  # [m], distance outside the reach that counts as rounding
ALIGNED = 1e-10  # sine, or [m], below which a free angle takes its reference value
STRETCHED = 1e-7  # sine of the elbow, or [m] from an offset shoulder's singularity; rounding of
# 1e-16 m at the edge of the reach, or of the offset, makes it 1e-8

SHOULDER, ELBOW, WRIST = 1, 2, 4


@njit(cache=True, error_model="numpy")
def _wrist(R, th1, th2, th3, g, reference, theta, flipped):
    """theta 4..6 for wrist rotation R and arm angles 1..3, and the same with the wrist flipped.

    True when axes 4 and 6 align, and both are the member of the family at the reference theta4.
    """
    sa, ca, sigma, t, s = g[2], g[3], g[8], g[9], g[10]
    c1, s1 = cos(th1), sin(th1)
    plane = th2 + sigma * th3
    c23, s23 = cos(plane), sin(plane)
    # Axes of frame 3 before its twist: x, y in the plane of the arm, z = sigma z_1.
    xx, xy, xz = c1 * c23 - s1 * ca * s23, s1 * c23 + c1 * ca * s23, sa * s23
    yx, yy, yz = -c1 * s23 - s1 * ca * c23, -s1 * s23 + c1 * ca * c23, sa * c23
    zx, zy, zz = sigma * s1 * sa, -sigma * c1 * sa, sigma * ca
    yx, yy, yz = sigma * yx, sigma * yy, sigma * yz
    s3, c3 = g[11], g[12]
    vx, vy, vz = c3 * yx + s3 * zx, c3 * yy + s3 * zy, c3 * yz + s3 * zz
    wx, wy, wz = -s3 * yx + c3 * zx, -s3 * yy + c3 * zy, -s3 * yz + c3 * zz
    r11 = xx * R[0, 0] + xy * R[1, 0] + xz * R[2, 0]
    r21 = vx * R[0, 0] + vy * R[1, 0] + vz * R[2, 0]
    r31 = wx * R[0, 0] + wy * R[1, 0] + wz * R[2, 0]
    r13 = xx * R[0, 2] + xy * R[1, 2] + xz * R[2, 2]
    r23 = vx * R[0, 2] + vy * R[1, 2] + vz * R[2, 2]
    r33 = wx * R[0, 2] + wy * R[1, 2] + wz * R[2, 2]
    sine = sqrt(r13 * r13 + r23 * r23)
    th5 = atan2(sine, -t * s * r33)
    aligned = sine < ALIGNED
    # When aligned only theta4 +- theta6 is determined: theta4 keeps its reference value.
    th4 = reference[3] if aligned else atan2(s * r23, s * r13)
    c4, s4, c5, s5 = cos(th4), sin(th4), cos(th5), sin(th5)
    # theta6 from the rest of the rotation, so that a rounding of theta4 is compensated
    th6 = atan2(t * s * (s4 * r11 - c4 * r21), c5 * (c4 * r11 + s4 * r21) + t * s5 * r31)
    turn = 0.0 if aligned else pi
    theta[0], theta[1], theta[2], theta[3], theta[4], theta[5] = th1, th2, th3, th4, th5, th6
    flipped[0], flipped[1], flipped[2] = th1, th2, th3
    flipped[3], flipped[4], flipped[5] = th4 + turn, th5 if aligned else -th5, th6 + turn
    return aligned


@njit(cache=True, error_model="numpy")
def branches(W, g, reference, theta, flags):
    """All eight branches of W = T from base axes to just after Rot_z(theta6).

    Fills theta (8, 6) and flags (8,), -1 where a branch does not exist. Returns the distance [m]
    of the wrist centre outside the reach, 0 where it is inside.
    """
    d1, a1, sa, ca, a2, L, beta, h, sigma = g[0], g[1], g[2], g[3], g[4], g[5], g[6], g[7], g[8]
    x, y, z = W[0, 3], W[1, 3], W[2, 3] - d1
    for b in range(8):
        flags[b] = -1
    rho = hypot(x, y)
    k = (h - ca * z) / sa
    if abs(k) > rho + TOUCHING:
        return abs(k) - rho
    along = sqrt(max(rho - abs(k), 0.0) * (rho + abs(k)))
    at_shoulder = rho < ALIGNED
    outside = 1e300
    for shoulder in range(2):
        forward = along if shoulder == 0 else -along
        th1 = reference[0] if at_shoulder else atan2(y, x) + atan2(k, forward)
        X = forward - a1
        Y = -ca * k + sa * z
        D = hypot(X, Y)
        gap = max(D - (a2 + L), abs(a2 - L) - D)
        if gap > TOUCHING:
            outside = min(outside, gap)
            continue
        outside = 0.0
        cosine = (D * D - a2 * a2 - L * L) / (2.0 * a2 * L)
        area = max(D - abs(a2 - L), 0.0) * (D + abs(a2 - L))
        area *= max(a2 + L - D, 0.0) * (a2 + L + D)
        sine = sqrt(area) / (2.0 * a2 * L)
        for elbow in range(2):
            bend = sine if elbow == 0 else -sine
            gamma = atan2(bend, cosine)
            th2 = atan2(Y, X) - atan2(L * bend, a2 + L * cosine)
            th3 = sigma * (gamma - beta)
            b = 4 * shoulder + 2 * elbow
            flag = 0
            if _wrist(W, th1, th2, th3, g, reference, theta[b], theta[b + 1]):
                flag |= WRIST
            if at_shoulder or along < STRETCHED:
                flag |= SHOULDER
            if sine < STRETCHED:
                flag |= ELBOW
            flags[b] = flags[b + 1] = flag
    return outside
