"""Axes that an elastic structure couples: those of equal parity to the arm's plane of symmetry.

With its joints at zero an arm is nearly its own mirror image. The second axis is normal to the
mirror: the plane in which a six-axis arm bends, or the one that a SCARA moves in. Rotation about
the normal and translation within the plane are even, all else is odd, and a structure that is its
own mirror image couples no even motion with an odd one.
"""

import itertools

import mujoco
import numpy as np

_ALONG = np.cos(np.pi / 4.0)  # cosine of the angle below which two axes count as parallel


def coupled_axes(mj: mujoco.MjModel, names: list[str]) -> tuple[tuple[int, int], ...]:
    """Pairs of axes, counted from 0: first the even ones, then the odd.

    names: of the joint of each axis.
    """
    data = mujoco.MjData(mj)
    mujoco.mj_kinematics(mj, data)
    joints = [int(mj.joint(name).id) for name in names]
    normal = data.xaxis[joints[min(1, len(joints) - 1)]]
    slides = mj.jnt_type[joints] == mujoco.mjtJoint.mjJNT_SLIDE
    even = (np.abs(data.xaxis[joints] @ normal) > _ALONG) != slides
    alike = np.flatnonzero(even).tolist(), np.flatnonzero(~even).tolist()
    return tuple(pair for axes in alike for pair in itertools.combinations(axes, 2))
