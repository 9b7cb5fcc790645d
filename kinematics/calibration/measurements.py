"""Measured configurations of an arm: motor angles, and what an instrument saw of its tool."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

SAME_POSE = 1e-3
"""Motor angles [rad or m] within which two rows are repeats of one pose."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Measurements:
    """N configurations of an arm of n motors with T targets fixed to its tool.

    phi (N, n) [rad], motor angles on the arm side of the gear; points (N, T, 3) [m] in the frame of
    the instrument, NaN where a target was not seen; rotation (N, 3, 3) of the tool in that frame,
    or None.
    """

    phi: Array
    points: Array
    rotation: Array | None = None
    row: NDArray[np.intp] | None = None
    """(N,) Row of each configuration in its file, from 1."""

    def __post_init__(self) -> None:
        if self.phi.ndim != 2 or self.points.shape[::2] != (len(self.phi), 3):
            given = f"got {self.phi.shape} and {self.points.shape}"
            raise ValueError(f"phi must be (N, n) and points (N, T, 3), {given}")
        if self.row is None:
            vars(self)["row"] = np.arange(1, 1 + len(self.phi))

    def __len__(self) -> int:
        return len(self.phi)

    def __getitem__(self, rows: slice | ArrayLike) -> "Measurements":
        """The configurations of a slice, with these indices, or where a mask is true."""
        assert self.row is not None
        chosen: Any = rows if isinstance(rows, slice) else np.asarray(rows)
        rotation = None if self.rotation is None else self.rotation[chosen]
        return Measurements(
            phi=self.phi[chosen],
            points=self.points[chosen],
            rotation=rotation,
            row=self.row[chosen],
        )

    @property
    def n_targets(self) -> int:
        """Number of targets T."""
        return self.points.shape[1]

    def moved(self, R: Array, p: Array) -> "Measurements":
        """The same in another frame: R (3, 3) and p (3,) take coordinates to it."""
        rotation = None if self.rotation is None else R @ self.rotation
        return replace(self, points=self.points @ R.T + p, rotation=rotation)


def unique_poses(phi: Array) -> NDArray[np.intp]:
    """Number of the pose of each row (N,), in order of appearance; repeats have the same one."""
    seen, number = np.unique(
        np.round(phi / SAME_POSE).astype(np.int64), axis=0, return_inverse=True
    )
    first = np.full(len(seen), len(phi))
    np.minimum.at(first, number.ravel(), np.arange(len(phi)))
    rank = np.empty(len(seen), dtype=np.intp)
    rank[np.argsort(first)] = np.arange(len(seen))
    return rank[number.ravel()]


def split_by_pose(
    phi: Array, fraction: float, rng: np.random.Generator | None
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices of rows to fit and rows held out; repeats of a pose are never on both sides.

    Args:
        fraction: of the poses, to be fitted.
        rng: draws the poses; None takes them in their order.
    """
    number = unique_poses(phi)
    order = np.arange(number.max() + 1)
    if rng is not None:
        order = rng.permutation(order)
    fitted = np.isin(number, order[: round(fraction * len(order))])
    return np.flatnonzero(fitted), np.flatnonzero(~fitted)
