"""Covariance of the tool's estimated path: filter, springs, encoders and gear errors.

    P(t) = T P_filter T^T + S(t) cov(theta) S(t)^T + J (E + diag v(t)) J^T

The filter counts what disturbs a known arm whose motor angles are exact. S are sensitivities of the
displacement from rest to the identified parameters theta, E is the variance of an encoder's counts,
and v that of gear errors of a type's amplitudes a_h and orders o_h, whose phases nobody knows:
v = sum_h a_h^2 (1 - cos(o_h (phi - phi_0))). What the filter takes away of all but its own is not
counted: the covariance is an upper bound, but for what no arm of this structure can be.
"""

import mujoco
import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.prediction_error import ParameterEstimate

from ..instruments.encoder import resolution
from ..robot.drives import EXACT, Drives
from ..robot.effects import Effect, available, gear_orders
from ..robot.model import RobotModel
from .deflection import deflection
from .elasticity import Elasticity, parameters_at
from .estimator import ToolEstimator
from .relative_path import REST_SAMPLES
from .rigid_motion import ENCODER_FILTER, RigidMotion

_STEP = 1e-3  # of the differences for sensitivities


def tool_covariance(
    known: ToolEstimator, fit: ParameterEstimate, nominal: Elasticity, robot: RobotModel
) -> Array:
    """(N, 3, 3) [m^2] of the displacement from rest along the first run, by encoders and amplitudes
    of gear errors of the robot's type."""
    motion = known.along
    J = tool_jacobian(motion)[:, :3]
    S = sensitivities(motion, nominal, fit.theta, J)
    P = S @ fit.covariance[: S.shape[2], : S.shape[2]] @ np.swapaxes(S, 1, 2)
    P += known.filter_covariance[known.place]
    variance = np.zeros((len(motion.time), robot.n_axes))
    variance += encoder_variance(robot.drives, motion.period)
    if known.arm.gear_error is EXACT and Effect.GEAR_ERROR in available(robot):
        variance += gear_variance(robot, motion.phi - motion.phi[0])
    axes = J[:, :, known.arm.axes]
    return P + (axes * variance[:, None, :]) @ np.swapaxes(axes, 1, 2)


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
    """(N, 3, m) of the displacement [m] to the parameters of the springs, the first of theta."""
    n_springs = len(nominal.stiffness) + 3

    def displaced(at: Array) -> Array:
        d = deflection(motion, parameters_at(nominal, at).springs).angle
        path = (J @ d[:, :, None])[:, :, 0]
        return path - path[:REST_SAMPLES].mean(axis=0)

    here = displaced(theta)
    steps = _STEP * np.eye(len(theta))[:n_springs]
    return np.stack([(displaced(theta + step) - here) / _STEP for step in steps], axis=2)


def encoder_variance(drives: Drives, period: float) -> Array:
    """(n,) [rad^2] of the gears' outputs from rest: rounding to counts, white along a motion and
    one constant error at rest, and noise; the low-pass leaves 2 f T of what is white."""
    if not drives.encoder_counts > 0.0:
        return np.zeros(len(drives.gear))
    left = min(2.0 * ENCODER_FILTER * period, 1.0)
    count = resolution(drives.encoder_counts, drives.gear) ** 2
    return count * ((1.0 + left) / 12.0 + left * drives.encoder_noise**2)


def gear_variance(robot: RobotModel, turned: Array) -> Array:
    """(N, n) [rad^2] of gear errors of unknown phase, for motor angles (N, n) [rad] from rest."""
    amplitude, order = gear_orders(robot)
    error = amplitude**2 * (1.0 - np.cos(turned[:, :, None] * order))
    return np.asarray(error.sum(axis=2), dtype=np.float64)
