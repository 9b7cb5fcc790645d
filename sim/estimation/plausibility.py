"""Plausibility of an estimated tool path against the encoders.

Between the rigid path of the measured motor angles and the path of the tool there is only what the
springs give way. Its size follows from the quasi-static deflection of the linear arm,

    (K + G) dq = K dphi - M dphi''

Resonances amplify it; an estimate that is much further off is no estimate.
"""

import mujoco
import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..robot.servo import interpolate
from .linearised_arm import LinearisedArm
from .nominal import NominalArm
from .observer import ENCODER_FILTER
from .relative_path import relative_to_start

AMPLIFICATION = 5.0
"""Largest deflection of an estimate over the quasi-static one. Cuts at 40 to 149 mm/s show 0.2 to
1.7."""
FLOOR = 0.5e-3
"""Deflection that is always plausible [m]. ESTIMATE."""


class EstimateError(RuntimeError):
    """An estimate of the tool's path that the motor angles contradict."""


def check_plausible(
    displacement: Array, arm: NominalArm, linear: LinearisedArm, motor_angle: Array, period: float
) -> None:
    """Raise EstimateError for an estimate that the encoders contradict.

    displacement: (N, 3) [m], of the tool from rest, base axes. linear: the arm at rest before the
    motion. motor_angle: (N, a) [rad], every `period` [s].
    """
    smooth = ZeroPhaseButterworth(ENCODER_FILTER, period)(motor_angle)
    phi, _, phi_ddot = interpolate(smooth, period, 1)
    rigid = relative_to_start(rigid_position(arm, phi))[:, :3]
    expected = relative_to_start(quasi_static_deflection(linear, phi - phi[0], phi_ddot))[:, :3]
    allowed = max(FLOOR, AMPLIFICATION * float(np.linalg.norm(expected, axis=1).max()))
    off = np.linalg.norm(displacement - rigid, axis=1)
    worst = int(np.argmax(np.where(np.isfinite(off), off, np.inf)))
    if not off[worst] <= allowed:
        raise EstimateError(
            f"the estimate of the tool is {1e3 * off[worst]:.3g} mm off what the motors show at "
            f"{worst * period:.2f} s; springs explain {1e3 * allowed:.2g} mm at most"
        )


def rigid_position(arm: NominalArm, phi: Array) -> Array:
    """(N, 3) [m], the tool of the rigid arm at motor angles (N, a), base axes."""
    motion, q = arm.motion, np.zeros(arm.n_free)
    mj, data, position = motion.mj, motion.data(), np.empty((len(phi), 3))
    site = mj.site("tool0").id
    for i, angles in enumerate(phi):
        q[arm.axes] = angles
        motion.place(data, q)
        mujoco.mj_kinematics(mj, data)
        position[i] = data.site_xpos[site]
    return position


def quasi_static_deflection(linear: LinearisedArm, phi: Array, phi_ddot: Array) -> Array:
    """(N, 3) [m], displacement of the tool by springs, for motor angles from rest (N, a)."""
    axes = linear.axes
    pull = phi @ (linear.stiffness - linear.spring_matrix[axes][:, axes]).T
    load = np.zeros((len(phi), linear.n_free))
    load[:, axes] = pull
    load -= phi_ddot @ linear.mass[:, axes].T
    return np.linalg.solve(linear.spring_matrix, load.T).T @ linear.tool_jacobian[:3].T
