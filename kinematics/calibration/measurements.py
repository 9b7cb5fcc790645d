"""Measured configurations of an arm, and the first estimate of frame, targets and tool rotation.

The frame of the instrument, p_frame = R p_base + p, and the targets t in the tool frame are found
in turns: each is a linear or a Procrustes problem when the other is known.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, real_array

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
    row: Any = None
    """(N,) Row of each configuration in its file, from 1; as they are counted by default."""

    def __post_init__(self) -> None:
        real_array("phi", self.phi)
        real_array("points", self.points)
        if self.phi.ndim != 2 or self.points.shape[::2] != (len(self.phi), 3):
            given = f"got {self.phi.shape} and {self.points.shape}"
            raise ValueError(f"phi must be (N, n) and points (N, T, 3), {given}")
        row = np.arange(1, 1 + len(self.phi)) if self.row is None else self.row
        vars(self)["row"] = row
        if (bad := np.argwhere(~np.isfinite(self.phi))).size:
            at, motor = bad[0]
            raise ValueError(f"motor_angle_{motor + 1} is not finite in row {row[at]}")

    def __len__(self) -> int:
        return len(self.phi)

    def __getitem__(self, rows: slice | ArrayLike) -> "Measurements":
        """The configurations of a slice, with these indices, or where a mask is true."""
        chosen: Any = rows if isinstance(rows, slice) else np.asarray(rows)
        rotation = None if self.rotation is None else self.rotation[chosen]
        phi, points, row = (each[chosen] for each in (self.phi, self.points, self.row))
        return Measurements(phi=phi, points=points, rotation=rotation, row=row)

    @property
    def n_targets(self) -> int:
        """Number of targets T."""
        return self.points.shape[1]

    def moved(self, R: Array, p: Array) -> "Measurements":
        """The same in another frame: R (3, 3) and p (3,) take coordinates to it."""
        rotation = None if self.rotation is None else R @ self.rotation
        return replace(self, points=self.points @ R.T + p, rotation=rotation)


def unique_poses(phi: Array) -> NDArray[np.intp]:
    """Number of the pose of each row (N,), in order of appearance; repeats have the same one.

    A repeat is near the first row of its pose, so that a slow motion is not all one pose.
    """
    from scipy.spatial import KDTree

    near = KDTree(phi).query_ball_point(phi, SAME_POSE, p=np.inf)
    number, count = np.full(len(phi), -1), 0
    for row, rows in enumerate(near):
        if number[row] < 0:
            number[[other for other in rows if number[other] < 0]] = count
            count += 1
    return number


def split_by_pose(
    phi: Array, fraction: float, rng: np.random.Generator | None
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices of rows to fit and rows held out; repeats of a pose are never on both sides.

    fraction: of the poses, to be fitted.
    rng: draws the poses; None takes them in their order.
    """
    number = unique_poses(phi)
    order = np.arange(number.max() + 1)
    if rng is not None:
        order = rng.permutation(order)
    fitted = np.isin(number, order[: round(fraction * len(order))])
    return np.flatnonzero(fitted), np.flatnonzero(~fitted)


TURNS = 200
"""Most alternations; they converge by a factor of about the tool's part of the reach."""
SETTLED = 1e-7
"""[m] Change of the targets at which the alternation ends."""


class Registration(NamedTuple):
    """Frames of the nominal robot: p_frame = R (pose(phi) t) + p."""

    R: Array
    """(3, 3), base to the frame of the instrument."""
    p: Array
    """(3,) [m]."""
    targets: Array
    """(T, 3) [m], in the tool frame of the robot."""
    R_tool: Array
    """(3, 3), measured tool frame in that of the robot; the identity where none was measured."""


def register(T_base_tool: Array, data: Measurements) -> Registration:
    """Registration of nominal poses (N, 4, 4) with what was measured, by least squares."""
    from scipy.spatial.transform import Rotation

    R_tool, p_tool = T_base_tool[:, :3, :3], T_base_tool[:, :3, 3]
    seen = np.asarray(np.isfinite(data.points).all(axis=2))
    targets = np.zeros((data.n_targets, 3))
    R, p = np.eye(3), np.zeros(3)
    for _ in range(TURNS):
        nominal = p_tool[:, None] + np.einsum("nij,tj->nti", R_tool, targets)
        R, p = procrustes(nominal[seen], data.points[seen])
        before, in_base = targets, (data.points - p) @ R
        local = np.einsum("nji,ntj->nti", R_tool, in_base - p_tool[:, None])
        targets = np.stack([local[own, t].mean(axis=0) for t, own in enumerate(seen.T)])
        if np.abs(targets - before).max() < SETTLED:
            break
    if data.rotation is None:
        return Registration(R, p, targets, np.eye(3))
    measured = Rotation.from_matrix(np.swapaxes(R_tool, 1, 2) @ R.T @ data.rotation)
    return Registration(R, p, targets, measured.mean().as_matrix())


def procrustes(source: Array, goal: Array) -> tuple[Array, Array]:
    """Rotation R and translation p of least squares, goal = R source + p; points (N, 3)."""
    a, b = source.mean(axis=0), goal.mean(axis=0)
    u, _, vt = np.linalg.svd((goal - b).T @ (source - a))
    R = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return R, b - R @ a
