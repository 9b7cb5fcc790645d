"""Closed chains: motion of the passive joints of a linkage, and of a model in its free joints.

A closed chain is an open tree whose cut is held together by `connect` constraints between two
sites. Its passive joints (link_*) follow a motion dq of the other joints so that the cut stays
closed. `Linkage` computes that motion from the geometry, without the constraint solver, and
`FreeMotion` the motion of the whole model from that of the free joints q:

    q_whole' = Z q'        q_whole'' = Z q'' + Z' q'        force = Z^T force_whole

Z is the linkage's tangent. Without cuts every joint is free and Z is the identity.
"""

import copy

import mujoco
import numpy as np

from armside.arrays import Array

LARGEST_GAP = 1e-6
"""Largest opening of a cut in a valid run [m]."""
_CLOSING_STEPS = 20
_CLOSED = 1e-14  # [m]; rounding of coordinates of the order of a metre


class Linkage:
    """Cuts and passive joints of one model; without cuts every joint is free."""

    def __init__(self, mj: mujoco.MjModel) -> None:
        self._mj = mj
        self._passive = passive_joints(mj)
        self._cuts = [
            (int(mj.eq_obj1id[i]), int(mj.eq_obj2id[i]))
            for i in range(mj.neq)
            if mj.eq_type[i] == mujoco.mjtEq.mjEQ_CONNECT
        ]

    @property
    def is_open(self) -> bool:
        """True for a tree without cuts."""
        return not self._cuts

    def gap(self, data: mujoco.MjData) -> Array:
        """Opening of the cuts, (3 * number of cuts,) [m], base axes, after mj_kinematics."""
        return np.concatenate([data.site_xpos[a] - data.site_xpos[b] for a, b in self._cuts])

    def jacobian(self, data: mujoco.MjData) -> Array:
        """Jacobian of `gap`, (3 * number of cuts, nv) [m/rad], after mj_comPos too."""
        rows = np.empty((3 * len(self._cuts), self._mj.nv))
        other = np.empty((3, self._mj.nv))
        for i, (a, b) in enumerate(self._cuts):
            mujoco.mj_jacSite(self._mj, data, rows[3 * i : 3 * i + 3], None, a)
            mujoco.mj_jacSite(self._mj, data, other, None, b)
            rows[3 * i : 3 * i + 3] -= other
        return rows

    def close(self, data: mujoco.MjData) -> None:
        """Move the passive joints alone so that the cuts close, or raise RuntimeError."""
        if self.is_open:
            return
        gap = np.full(3, np.inf)
        for _ in range(_CLOSING_STEPS):
            mujoco.mj_kinematics(self._mj, data)
            mujoco.mj_comPos(self._mj, data)
            gap = self.gap(data)
            if np.abs(gap).max() < _CLOSED:
                return
            passive = self.jacobian(data)[:, self._passive]
            data.qpos[self._passive] -= np.linalg.lstsq(passive, gap)[0]
        raise RuntimeError(f"the linkage stays open by {np.abs(gap).max():.3g} m")

    def tangent(self, data: mujoco.MjData) -> Array:
        """Z (nv, nv): dq = Z dq keeps the cuts closed; Z has zero columns at the passive joints.

        Forces act on the free joints as Z.T @ force.
        """
        Z = np.eye(self._mj.nv)
        if self.is_open:
            return Z
        jacobian = self.jacobian(data)
        Z[self._passive] = -np.linalg.lstsq(jacobian[:, self._passive], jacobian)[0]
        Z[:, self._passive] = 0.0
        return Z

    def following_acceleration(self, data: mujoco.MjData) -> Array:
        """(nv,) [rad/s^2], of the passive joints by the rates of all, after mj_comVel.

        J q'' + J' q' = 0 with the other joints' q'' zero: what `tangent` leaves of q''.
        """
        left = np.concatenate([self._rate(data, a) - self._rate(data, b) for a, b in self._cuts])
        acceleration = np.zeros(self._mj.nv)
        passive = self.jacobian(data)[:, self._passive]
        acceleration[self._passive] = -np.linalg.lstsq(passive, left)[0]
        return acceleration

    def _rate(self, data: mujoco.MjData, site: int) -> Array:
        """J' q' of a site, (3,) [m/s^2]."""
        rate, body = np.empty((3, self._mj.nv)), int(self._mj.site_bodyid[site])
        mujoco.mj_jacDot(self._mj, data, rate, None, data.site_xpos[site], body)
        return rate @ data.qvel


def passive_joints(mj: mujoco.MjModel) -> np.ndarray:
    """Degrees of freedom of the joints link_*."""
    dofs = [j.dofadr[0] for j in map(mj.joint, range(mj.njnt)) if j.name.startswith("link_")]
    return np.array(dofs, dtype=int)


def loop_error(mj: mujoco.MjModel, qpos: Array) -> float:
    """Widest opening of any cut over the positions (M, nq) [m]; 0 for an open chain."""
    linkage = Linkage(mj)
    if linkage.is_open:
        return 0.0
    data, widest = mujoco.MjData(mj), 0.0
    for q in qpos:
        data.qpos[:] = q
        mujoco.mj_kinematics(mj, data)
        widest = max(widest, float(np.abs(linkage.gap(data)).max()))
    return widest


def checked_loop_error(mj: mujoco.MjModel, qpos: Array) -> float:
    """`loop_error`. Raises RuntimeError above `LARGEST_GAP`, where the run is not valid."""
    widest = loop_error(mj, qpos)
    if widest > LARGEST_GAP:
        raise RuntimeError(
            f"a closed chain opened by {1e6 * widest:.3g} um, more than {1e6 * LARGEST_GAP:g} um: "
            f"shorten the time step or soften the motion"
        )
    return widest


class FreeMotion:
    """Free joints of one model. Its data hold no forces of constraints."""

    def __init__(self, mj: mujoco.MjModel, follow: Array | None = None) -> None:
        """follow: (nv, n), joint angles from the n free ones, near which the linkage closes."""
        self.mj, self.linkage = mj, Linkage(mj)
        self.is_open, self.joints = self.linkage.is_open, free_joints(mj)
        if not self.is_open:
            self.mj = copy.copy(mj)
            self.mj.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        self._follow = np.eye(mj.nv)[:, self.joints] if follow is None else follow

    def data(self) -> mujoco.MjData:
        """Scratch data for the methods below."""
        return mujoco.MjData(self.mj)

    def place(self, data: mujoco.MjData, q: Array) -> None:
        """Free joints at q, (n,) [rad]; passive ones close the cuts, or RuntimeError."""
        if self.is_open:
            data.qpos[:] = q
            return
        data.qpos[:] = self._follow @ q
        self.linkage.close(data)

    def move(self, data: mujoco.MjData, q: Array, q_dot: Array, q_ddot: Array) -> None:
        """Position, velocity and acceleration of all joints from those of the free, (n,) each."""
        self.place(data, q)
        if self.is_open:
            data.qvel[:], data.qacc[:] = q_dot, q_ddot
            return
        Z = self._tangent(data)
        data.qvel[:] = Z @ q_dot
        mujoco.mj_comVel(self.mj, data)
        data.qacc[:] = Z @ q_ddot + self.linkage.following_acceleration(data)

    def forces(self, data: mujoco.MjData, whole: Array) -> Array:
        """(n,) forces on the free joints of forces (nv,) on all of them, where data are placed."""
        return whole.copy() if self.is_open else self._tangent(data).T @ whole

    def mass(self, data: mujoco.MjData) -> Array:
        """(n, n) inertia of the free joints, after mj_forward."""
        M = np.empty((self.mj.nv, self.mj.nv))
        mujoco.mj_fullM(self.mj, data, M)
        if self.is_open:
            return M
        Z = self._tangent(data)
        return Z.T @ M @ Z

    def jacobian(self, data: mujoco.MjData, site: int) -> Array:
        """(6, n), (v, omega) of a site in base axes for the free joints' rates."""
        J = np.empty((6, self.mj.nv))
        mujoco.mj_jacSite(self.mj, data, J[:3], J[3:], site)
        return J if self.is_open else J @ self._tangent(data)

    def _tangent(self, data: mujoco.MjData) -> Array:
        return self.linkage.tangent(data)[:, self.joints]


def free_joints(mj: mujoco.MjModel) -> np.ndarray:
    """Degrees of freedom that closed chains leave free, ascending."""
    every = np.arange(mj.nv)
    return every if Linkage(mj).is_open else np.setdiff1d(every, passive_joints(mj))
