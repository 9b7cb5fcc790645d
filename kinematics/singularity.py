"""Singular configurations of any serial robot of numbers, by the rank of its Jacobian."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, finite_array

from .compiled import CompiledRobot, compile
from .dh import Robot
from .inverse.numeric import spread

_RANK = 1e-9  # singular values below this fraction of the greatest count as zero
_SAMPLES = 32  # configurations that the regular rank is taken from
_FIRST_ORDER = 1e-6  # length below which a direction does not return to first order


@dataclass(frozen=True)
class RankLoss:
    """Rank of a robot's Jacobian at one configuration, and what it has lost there.

    `lost`: unit six-vectors (v, omega) in base axes as columns, shape (6, k): directions that the
    tool has in regular configurations and not here. `idle`: unit motor rates as columns, shape
    (n, n - rank), that do not move the tool; k or more of them at a singularity.
    """

    rank: int
    regular_rank: int
    least_singular_value: float
    """Of those that are not zero in regular configurations."""
    lost: Array
    idle: Array

    @property
    def is_singular(self) -> bool:
        """True if the tool can move in fewer directions than elsewhere."""
        return self.rank < self.regular_rank


def rank_loss(robot: Robot, phi: ArrayLike) -> RankLoss:
    """Rank, lost directions and idle motors of a robot at phi, shape (n,)."""
    phi = finite_array("phi", phi, robot.n_joints)
    functions, regular = compile(robot), regular_rank(robot)
    U, S, Vt = np.linalg.svd(functions.jacobian(phi))
    rank = int((_RANK * S[0] < S).sum())
    beyond, idle = U[:, rank:], Vt[rank:].T
    count = max(regular - rank, 0)
    lost = beyond if regular == 6 else _returning(functions, phi, beyond, idle)[:, :count]
    return RankLoss(rank, regular, float(S[regular - 1]), lost, idle)


@lru_cache(maxsize=64)
def regular_rank(robot: Robot) -> int:
    """Rank of the Jacobian in almost all configurations: 6, 3 for a planar arm, ..."""
    J = compile(robot).jacobian(spread(robot, None, _SAMPLES))
    S = np.linalg.svd(J, compute_uv=False)
    return int((_RANK * S[:, :1] < S).sum(axis=1).max())


def _returning(functions: CompiledRobot, phi: Array, beyond: Array, idle: Array) -> Array:
    """Directions beyond the range of J, (6, k), that idle motors gain as any motor moves on.

    d(J v) = J'(motor) v for idle rates v: what of it lies beyond the range of J returns.
    """
    units = np.eye(len(phi))
    rates = [functions.jacobian_rate(phi, unit) @ idle for unit in units]
    gained = beyond @ (beyond.T @ np.concatenate(rates, axis=1))
    U, S, _ = np.linalg.svd(gained)
    return U[:, : int((S > _FIRST_ORDER).sum())]
