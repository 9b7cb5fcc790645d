"""Inertia and load of gravity of an arm with rigid gears, from which drives are estimated."""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from armside.arrays import Array
from armside.kinematics import Limits

_DRAWN = 100
"""Random configurations within the limits."""


@dataclass(frozen=True, eq=False)
class RigidArm:
    """A compiled arm with the joints motor_1..n alone, without rotors and springs."""

    mj: mujoco.MjModel
    home: Array
    """(n,) [rad], motor angles at which inertia and modes are taken."""
    limits: Limits

    @cached_property
    def mass_matrix(self) -> Array:
        """(n, n) [kg m^2] at home."""
        data, M = mujoco.MjData(self.mj), np.zeros((self.mj.nv, self.mj.nv))
        data.qpos[:] = self.home
        mujoco.mj_forward(self.mj, data)
        mujoco.mj_fullM(self.mj, data, M)
        return M

    @property
    def inertia(self) -> Array:
        """(n,) [kg m^2] that each motor moves at home, the other axes held."""
        return np.diag(self.mass_matrix).copy()

    @property
    def own_inertia(self) -> Array:
        """(n,) [kg m^2] that each motor feels at home, the other axes free: the smallest."""
        inverse = np.asarray(np.linalg.inv(self.mass_matrix), dtype=np.float64)
        return 1.0 / np.diag(inverse)

    @cached_property
    def gravity_load(self) -> Array:
        """(n,) [N m], greatest load of gravity at home and in random configurations."""
        rng, data = np.random.default_rng(0), mujoco.MjData(self.mj)
        drawn = rng.uniform(self.limits.lower, self.limits.upper, (_DRAWN, len(self.home)))
        load = np.zeros(len(self.home))
        for q in (self.home, *drawn[self.limits.contain(drawn)]):
            data.qpos[:], data.qvel[:], data.qacc[:] = q, 0.0, 0.0
            mujoco.mj_inverse(self.mj, data)
            load = np.maximum(load, np.abs(data.qfrc_inverse))
        return load

    def lowest_mode(self, stiffness: Array) -> float:
        """Lowest natural frequency [Hz] at home on gear springs (n,); infinite without any."""
        from scipy.linalg import eigh

        if not len(stiffness):
            return np.inf
        omega_squared = eigh(np.diag(stiffness), self.mass_matrix, eigvals_only=True)
        return float(np.sqrt(max(omega_squared[0], 0.0)) / (2.0 * np.pi))
