"""Closed-form inverse kinematics of one kind of arm: the compiled loops over branches and targets.

`closed_form` joins the text of this file to that of a kind, `wrist_kernel` or `parallel_kernel`,
whose `branches` it calls, and `cache` compiles the whole; the interface is there too. Angles here
are D-H angles theta as that kind counts them, theta = M phi + constant.
"""

from math import floor, pi

import numpy as np
from numba import njit

from .wrist_kernel import branches


@njit(cache=True, error_model="numpy")
def _wrap(angle, reference):
    """The angle plus the multiple of 2 pi that brings it nearest to the reference."""
    return angle - 2.0 * pi * floor((angle - reference) / (2.0 * pi) + 0.5)


@njit(cache=True, error_model="numpy")
def _solve_one(W, g, M_inv, constant, theta_reference, theta, phi, flags):
    """Branches of one target as motor angles, each theta within pi of its reference."""
    outside = branches(W, g, theta_reference, theta, flags)
    for b in range(8):
        for i in range(6):
            theta[b, i] = _wrap(theta[b, i], theta_reference[i])
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += M_inv[i, j] * (theta[b, j] - constant[j])
            phi[b, i] = total
    return outside


_ALL = "void(f8[:,:,::1], f8[::1], f8[:,::1], f8[::1], f8[::1], f8[:,:,::1], i1[:,::1], f8[::1])"


@njit(_ALL, cache=True, error_model="numpy", nogil=True)
def solve_all(W, g, M_inv, constant, theta_reference, phi, flags, outside):
    """Every branch of every target: phi (N, 8, 6), flags (N, 8), outside (N,)."""
    theta = np.empty((8, 6))
    for k in range(W.shape[0]):
        outside[k] = _solve_one(W[k], g, M_inv, constant, theta_reference, theta, phi[k], flags[k])


_FOLLOW = "i8(f8[:,:,::1], f8[::1], f8[:,::1], f8[:,::1], f8[::1], f8[:,::1], i1[::1], f8[::1])"


@njit(_FOLLOW, cache=True, error_model="numpy", nogil=True)
def follow(W, g, M, M_inv, constant, path, flag, outside):
    """One branch through targets 1.. from path[0], which is given.

    Each next row of path is the solution nearest to the row before. Returns the index of the
    first target out of reach, or the number of targets.
    """
    theta, phi, reference = np.empty((8, 6)), np.empty((8, 6)), np.empty(6)
    flags = np.empty(8, np.int8)
    for k in range(1, W.shape[0]):
        for i in range(6):
            reference[i] = constant[i]
            for j in range(6):
                reference[i] += M[i, j] * path[k - 1, j]
        outside[k] = _solve_one(W[k], g, M_inv, constant, reference, theta, phi, flags)
        best, nearest = -1, 1e300
        for b in range(8):
            if flags[b] >= 0:
                distance = 0.0
                for i in range(6):
                    distance += (phi[b, i] - path[k - 1, i]) ** 2
                if distance < nearest:
                    best, nearest = b, distance
        if best < 0:
            return k
        for i in range(6):
            path[k, i] = phi[best, i]
        flag[k] = flags[best]
    return W.shape[0]
