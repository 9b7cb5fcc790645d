"""Natural frequencies of a robot model, linearised.

The springs of gears and structure restore; gravity and a balancing cylinder are left out.
"""

import mujoco
import numpy as np

from armside.arrays import Array

from .linkage import Linkage, passive_joints
from .model import RobotModel
from .statics import spring_stiffness


def natural_frequencies(model: RobotModel, phi: Array, *, locked: bool) -> Array:
    """Undamped natural frequencies [Hz], ascending, at motor angles phi (n,) [rad].

    M q'' + K q = 0 about every spring at zero, in the joints that a closed chain leaves free. K has
    the springs of gears and structure, those of a gear with lost motion as they are under load.

    locked: the motors are held; otherwise they turn freely, without servo, and each has a motion of
    0 Hz.
    """
    from scipy.linalg import eigh

    M, free = _reduced_inertia(model, phi)
    K = np.zeros(model.mj.nv)
    K[model.springs] = spring_stiffness(model)
    moving = np.setdiff1d(free, model.motor) if locked else free
    if not len(moving):
        return np.zeros(0)
    omega_squared = eigh(np.diag(K[moving]), M[np.ix_(moving, moving)], eigvals_only=True)
    return np.sqrt(np.maximum(omega_squared, 0.0)) / (2.0 * np.pi)


def _reduced_inertia(model: RobotModel, phi: Array) -> tuple[Array, np.ndarray]:
    """Inertia (nv, nv) of motions that keep closed chains closed, and the joints free in them."""
    mj, data = model.mj, mujoco.MjData(model.mj)
    linkage, M = Linkage(mj), np.zeros((mj.nv, mj.nv))
    data.qpos[:] = model.posture @ phi
    mujoco.mj_forward(mj, data)
    mujoco.mj_fullM(mj, data, M)
    Z = linkage.tangent(data)
    closed = np.array([], dtype=int) if linkage.is_open else passive_joints(mj)
    return Z.T @ M @ Z, np.setdiff1d(np.arange(mj.nv), closed)
