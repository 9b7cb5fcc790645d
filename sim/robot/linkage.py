"""Closed chains: motion of the passive joints of a linkage.

A closed chain is an open tree whose cut is held together by `connect` constraints between two
sites. Its passive joints (link_*) follow a motion dq of the other joints so that the cut stays
closed. `Linkage` computes that motion from the geometry, without the constraint solver.
"""

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
        """Move the passive joints so that the cuts close; the other joints stay.

        Raises RuntimeError when they cannot be closed.
        """
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
