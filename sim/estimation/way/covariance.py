"""Covariance of an estimated tool path: filter, identified springs, and unknown gear errors.

    P(t) = T P_filter T^T + S(t) cov(theta) S(t)^T + sum_i v_i(t) J_i J_i^T

S are sensitivities of the displacement from rest to the identified constants. The gear error of an
axis has the amplitudes a_h and orders o_h that its type has, and phases that nobody knows: its
displacement from rest has the variance v = sum_h a_h^2 (1 - cos(o_h (phi - phi_0))). What the
filter takes away of the last two is not counted: the covariance is an upper bound.
"""

import mujoco
import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.prediction_error import ParameterEstimate

from ...robot.drives import EXACT
from ...robot.effects import Effect, available
from ...robot.model import RobotModel
from ..relative_path import REST_SAMPLES
from ..tool_covariance import gear_variance
from .deflection import deflection
from .elasticity import Elasticity
from .estimator import WayEstimator
from .parameters import constants_at
from .rigid_motion import RigidMotion

_STEP = 1e-3


def tool_covariance(
    known: WayEstimator, fit: ParameterEstimate, nominal: Elasticity, robot: RobotModel
) -> Array:
    """(N, 3, 3) [m^2] of the displacement from rest, along the first run's motion."""
    J = tool_jacobian(known.along)[:, :3]
    S = sensitivities(known.along, nominal, fit.theta, J)
    P = S @ fit.covariance[: S.shape[2], : S.shape[2]] @ np.swapaxes(S, 1, 2)
    P += known.filter_covariance[known.place]
    if known.arm.gear_error is EXACT and Effect.GEAR_ERROR in available(robot):
        P += _of_gears(known.along, robot, J)
    return P


def tool_jacobian(motion: RigidMotion) -> Array:
    """(N, 6, n), (v, omega) of the tool in base axes along a rigid motion."""
    free = motion.arm.motion
    data, site = free.data(), free.mj.site("tool0").id
    found = np.empty((len(motion.phi), 6, motion.arm.n_free))
    q = np.zeros(motion.arm.n_free)
    for i, phi in enumerate(motion.phi):
        q[motion.arm.axes] = phi
        free.place(data, q)
        mujoco.mj_fwdPosition(free.mj, data)
        found[i] = free.jacobian(data, site)
    return found


def sensitivities(motion: RigidMotion, nominal: Elasticity, theta: Array, J: Array) -> Array:
    """(N, 3, m) of the displacement [m] to the constants of the springs, the first of theta."""
    n_springs = len(nominal.stiffness) + 3

    def displaced(at: Array) -> Array:
        d = deflection(motion, constants_at(nominal, at, 1.0).springs).angle
        path = (J @ d[:, :, None])[:, :, 0]
        return path - path[:REST_SAMPLES].mean(axis=0)

    here = displaced(theta)
    steps = _STEP * np.eye(len(theta))[:n_springs]
    return np.stack([(displaced(theta + step) - here) / _STEP for step in steps], axis=2)


def _of_gears(motion: RigidMotion, robot: RobotModel, J: Array) -> Array:
    variance = gear_variance(robot, motion.phi - motion.phi[0])
    axes = J[:, :, motion.arm.axes]
    return (axes * variance[:, None, :]) @ np.swapaxes(axes, 1, 2)
