"""Rigid inverse dynamics, elastic deflection, static equilibrium and modes of a robot model.

The forces are without friction, damping and those of closed-chain constraints. A controller uses
`Statics` with the nominal model, for torque feedforward and for `anticipated_shift`.
"""

import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from armside.arrays import Array

from .linkage import Linkage, free_joints
from .mjcf import mass_matrix
from .model import RobotModel
from .servo import interpolate

_NEWTON_STEPS = 500  # a soft gear is approached with the slope of the stiff one
_REST_TORQUE = 1e-7  # [N m]; 1e-11 of the holding torque, 1e-13 rad at the softest spring

_ALL_STAGES = int(mujoco.mjtStage.mjSTAGE_NONE)
_AFTER_POSITION, _AFTER_VELOCITY = (
    int(mujoco.mjtStage.mjSTAGE_POS),
    int(mujoco.mjtStage.mjSTAGE_VEL),
)
_NO_SENSORS = 1


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """Static equilibrium of the flexible robot with its motors held."""

    qpos: Array
    holding_torque: Array
    """(nq,) [rad], and (n,) [N m], arm side, that the motors deliver."""


class Statics:
    """Forces and deflections of one model along a motion. Holds scratch data: one a thread."""

    def __init__(self, model: RobotModel) -> None:
        self.model = model
        self._mj = copy.copy(model.mj)
        flags = mujoco.mjtDisableBit.mjDSBL_DAMPER | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self._mj.opt.disableflags |= int(flags)
        self._data = mujoco.MjData(self._mj)
        self._linkage = Linkage(self._mj)
        self._stiffness = spring_stiffness(model)

    def rigid_forces(self, phi: Array, phi_dot: Array, phi_ddot: Array) -> Array:
        """Generalised forces (N, nv) [N m] of the rigid motion, every spring at zero deflection.

        They are the forces of the joints of the chain cut open, in which a spring carries its
        entry; `motor_torque` closes it. phi: (N, n) [rad], arm-side motor angles.
        """
        data, posture = self._data, self.model.posture.T
        forces = np.empty((len(phi), self._mj.nv))
        motion = phi @ posture, phi_dot @ posture, phi_ddot @ posture
        for i, (q, q_dot, q_ddot) in enumerate(zip(*motion, strict=True)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q, q_dot, q_ddot
            mujoco.mj_inverseSkip(self._mj, data, _ALL_STAGES, _NO_SENSORS)
            forces[i] = data.qfrc_inverse
        return forces

    def rigid_terms(self, phi: Array, slope: Array, bend: Array) -> Array:
        """(3, N, nv), `rigid_forces` at rest, with acceleration `slope`, and with velocity `slope`
        and acceleration `bend`: each posture is computed once."""
        data, posture = self._data, self.model.posture.T
        terms = np.empty((3, len(phi), self._mj.nv))
        motion = phi @ posture, slope @ posture, bend @ posture
        qpos, qvel, qacc, force = data.qpos, data.qvel, data.qacc, data.qfrc_inverse
        for i, (q, first, second) in enumerate(zip(*motion, strict=True)):
            qpos[:], qvel[:], qacc[:] = q, 0.0, 0.0
            mujoco.mj_inverseSkip(self._mj, data, _ALL_STAGES, _NO_SENSORS)
            terms[0, i] = force
            qacc[:] = first
            mujoco.mj_inverseSkip(self._mj, data, _AFTER_VELOCITY, _NO_SENSORS)
            terms[1, i] = force
            qvel[:], qacc[:] = first, second
            mujoco.mj_inverseSkip(self._mj, data, _AFTER_POSITION, _NO_SENSORS)
            terms[2, i] = force
        return terms

    def motor_torque(self, forces: Array) -> Array:
        """(..., n) [N m], arm side, that the drives deliver for `rigid_forces`, by virtual work."""
        return forces @ self.model.posture

    def deflection(self, phi: Array, forces: Array) -> Array:
        """Quasi-static displacement (N, 3) [m], base axes, of the tool from its rigid position.

        phi: (N, n) [rad]; forces: (N, nv) [N m] that the springs carry, from `rigid_forces`.
        """
        data, springs, site = self._data, self.model.springs, self._mj.site("tool0").id
        jacobian, moved = np.empty((3, self._mj.nv)), np.empty((len(phi), 3))
        for i, q in enumerate(phi @ self.model.posture.T):
            data.qpos[:] = q
            mujoco.mj_kinematics(self._mj, data)
            mujoco.mj_comPos(self._mj, data)
            mujoco.mj_jacSite(self._mj, data, jacobian, None, site)
            Z = self._linkage.tangent(data)
            carried = (Z.T @ forces[i])[springs]
            moved[i] = (jacobian @ Z)[:, springs] @ (-carried / self._stiffness)
        return moved

    def equilibrium(self, phi: Array) -> Equilibrium:
        """Static equilibrium with the motors held at phi, (n,) [rad]; RuntimeError without one."""
        data, motor, springs = self._data, self.model.motor, self.model.springs
        data.qvel[:] = data.qacc[:] = 0.0
        data.qpos[:] = self.model.posture @ phi
        for _ in range(_NEWTON_STEPS):
            self._linkage.close(data)
            mujoco.mj_inverse(self._mj, data)
            force = self._linkage.tangent(data).T @ data.qfrc_inverse
            residual = force[springs]
            if np.abs(residual).max(initial=0.0) < _REST_TORQUE:
                return Equilibrium(qpos=data.qpos.copy(), holding_torque=force[motor])
            data.qpos[springs] -= residual / self._stiffness
        raise RuntimeError(f"no static equilibrium at motor angles {np.round(phi, 4).tolist()}")


def spring_stiffness(model: RobotModel) -> Array:
    """Stiffness [N m/rad] of each of `model.springs` under load: soft and stiff part of a gear."""
    mj = model.mj
    stiffness = mj.jnt_stiffness[mj.dof_jntid[model.springs]].copy()
    for tendon in range(mj.ntendon):
        first, count = mj.tendon_adr[tendon], mj.tendon_num[tendon]
        if count == 1 and mj.wrap_type[first] == mujoco.mjtWrap.mjWRAP_JOINT:
            dof = mj.jnt_dofadr[mj.wrap_objid[first]]
            stiffness[model.springs == dof] += mj.tendon_stiffness[tendon]
    return stiffness


BOX = 5
"""Samples of the moving average that `smoothed` takes twice: 20 ms at the log rate, as in the
calibration of the large robot. ESTIMATE."""


def anticipated_shift(nominal: Statics, phi: Array, period: float) -> Array:
    """Elastic deflection (N, 3) [m], base axes, to subtract from the programmed tool positions.

    The controller's model is too stiff: it has the fraction `Drives.elastic_compensation` of the
    quasi-static deflection. phi: (N, n) [rad], of the programmed path, every `period` [s].
    """
    _, phi_dot, phi_ddot = interpolate(phi, period, 1)
    forces = nominal.rigid_forces(phi, phi_dot, phi_ddot)
    return nominal.model.drives.elastic_compensation * nominal.deflection(phi, forces)


def smoothed(shift: Array) -> Array:
    """Moving average of a shift (N, 3) [m], taken twice.

    Where the curvature of a contour jumps, acceleration and deflection jump too; motors cannot
    follow that within one sample.
    """
    kernel = np.convolve(np.ones(BOX), np.ones(BOX)) / BOX**2
    padded = np.pad(shift, ((BOX - 1, BOX - 1), (0, 0)), mode="edge")
    return np.column_stack([np.convolve(column, kernel, mode="valid") for column in padded.T])


def natural_frequencies(model: RobotModel, phi: Array, *, locked: bool) -> Array:
    """Undamped natural frequencies [Hz], ascending, at motor angles phi (n,) [rad].

    Gears with lost motion are as stiff as under load. locked: the motors are held; otherwise they
    turn freely, without servo, and each has a motion of 0 Hz.
    """
    from scipy.linalg import eigh

    mj, data = model.mj, mujoco.MjData(model.mj)
    M, free = mass_matrix(mj, model.posture @ phi, data), free_joints(mj)
    Z = Linkage(mj).tangent(data)
    M = Z.T @ M @ Z  # of motions that keep closed chains closed
    K = np.zeros(mj.nv)
    K[model.springs] = spring_stiffness(model)
    moving = np.setdiff1d(free, model.motor) if locked else free
    if not len(moving):
        return np.zeros(0)
    omega_squared = eigh(np.diag(K[moving]), M[np.ix_(moving, moving)], eigvals_only=True)
    return np.sqrt(np.maximum(omega_squared, 0.0)) / (2.0 * np.pi)
