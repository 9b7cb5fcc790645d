"""Path of the tool over a program's moves: lines, arcs, and a parabola in the zone of a target.

The parabola leaves the line to a target P_i at the distance of its zone, and joins the line from it
there: it is the quadratic Bezier curve with P_i in its middle. Makers say so of RAPID ("a corner
path, parabola"); of KRL and URScript it is assumed. A zone is at most half of the distance to the
next and the last target. So a row of MoveL is linear in its targets, path(w) = N(w) P, and with
zones of half the spacing it is the uniform quadratic B-spline with the targets as control points.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from armside.arrays import Array

from ...motion.instructions import MoveC, MoveL, Wait
from .program_text import Place, ProgramText

STEP = 1e-4
"""Between samples of a path [m]."""
SHORT = 1e-9
"""Distance of targets that are one [m]."""

Corner = Literal["parabola", "quintic", "sharp"]
CORNERS: Mapping[Corner, Callable[[Array], Array]] = {
    "parabola": lambda x: (1.0 - x) ** 2,
    "quintic": lambda x: (1.0 - x) ** 3 * (1.0 + x),
    "sharp": lambda x: (1.0 - x) ** 3,
}
"""A(x) of a corner P + A(x) (B - P) + A(1 - x) (C - P) from B to C, ends of the zone of P. Quintic:
without a jump of the acceleration; sharp: nearer to P, as some makers draw it. ESTIMATES"""


@dataclass(frozen=True, kw_only=True)
class Row:
    """Consecutive linear moves in one work object, from the target before them to the last."""

    moves: tuple[int, ...]
    """Index of the instruction that ends at each target; the first ends at the start."""
    targets: Array = field(repr=False)
    """P, (M, 3) [m], in the work object."""
    zones: Array = field(repr=False)
    """(M,) [m], as programmed."""

    def __post_init__(self) -> None:
        self.targets.setflags(write=False)

    @property
    def spacing(self) -> Array:
        """(M - 1,) [m], between targets."""
        return np.linalg.norm(np.diff(self.targets, axis=0), axis=1)

    @property
    def fractions(self) -> Array:
        """(M, 2), zone over the distance to the target before and after, at most a half."""
        before = np.concatenate([[np.inf], self.spacing])
        after = np.concatenate([self.spacing, [np.inf]])
        size = np.minimum(self.zones, 0.5 * np.minimum(before, after))
        size[[0, -1]] = 0.0  # it starts and ends at its ends
        return np.stack([size / np.maximum(before, SHORT), size / np.maximum(after, SHORT)], axis=1)

    @property
    def n_pieces(self) -> int:
        """A parabola at each target and a line between: w runs from 0 to this."""
        return 2 * len(self.targets) - 3

    def basis(self, w: ArrayLike, corner: Corner = "parabola") -> csr_array:
        """N(w), (K, M), sparse, of w (K,): pieces are unit intervals of w, lines first."""
        w = np.asarray(w, dtype=np.float64)
        piece = np.clip(w.astype(int), 0, self.n_pieces - 1)
        x, i, f = w - piece, piece // 2, self.fractions
        middle = i + piece % 2  # the parabola of piece 2 i + 1 is about target i + 1
        last = len(self.targets) - 1
        before, after = np.maximum(middle - 1, 0), np.minimum(middle + 1, last)
        f_in, f_out = f[middle, 0], f[middle, 1]
        enter, leave = CORNERS[corner](x) * f_in, CORNERS[corner](1 - x) * f_out
        curved = (enter, 1.0 - enter - leave, leave)
        # A line from P_i + f_out (P_i+1 - P_i) to P_i+1 + f_in (P_i - P_i+1).
        along = f_out + x * (1.0 - f[after, 0] - f_out)
        straight = (np.zeros_like(x), 1 - along, along)
        line = piece % 2 == 0
        weights = [np.where(line, s, c) for s, c in zip(straight, curved, strict=True)]
        rows = np.tile(np.arange(len(w)), 3)
        columns = np.concatenate([before, middle, after])
        shape = (len(w), len(self.targets))
        return csr_array((np.concatenate(weights), (rows, columns)), shape=shape)

    def path(self, w: ArrayLike, corner: Corner = "parabola") -> Array:
        """N(w) P, (K, 3) [m]."""
        return self.basis(w, corner) @ self.targets

    def samples(self, step: float = STEP) -> Array:
        """w at even fractions of each piece, at most `step` [m] apart along the polygon."""
        f, spacing = self.fractions, self.spacing
        length = np.empty(self.n_pieces)
        length[::2] = spacing * (1.0 - f[:-1, 1] - f[1:, 0])
        length[1::2] = f[1:-1, 0] * spacing[:-1] + f[1:-1, 1] * spacing[1:]
        parts = np.ceil(length / step).astype(int)
        grids = [k + np.arange(n) / n for k, n in enumerate(parts) if n]
        return np.concatenate([*grids, [float(self.n_pieces)]])


def arc_lengths(path: Array) -> Array:
    """(K,) [m], along the chords of a path (K, 3) [m]."""
    return np.concatenate([[0.0], np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()])


def nearest_across(
    path: Array, near: NDArray[np.int64], points: Array
) -> tuple[NDArray[np.int64], Array]:
    """Of points (K, 3) [m], the nearest place of a path each among those near it (K, n), and the
    vector (K, 3) [m] from there, across the path."""
    distance = np.linalg.norm(path[near] - points[:, np.newaxis], axis=2)
    foot = near[np.arange(len(points)), distance.argmin(axis=1)]
    away, tangent = points - path[foot], np.gradient(path, axis=0)[foot]
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-15)
    return foot, away - np.sum(away * tangent, axis=1, keepdims=True) * tangent


def rows_of(program: ProgramText) -> list[Row]:
    """Rows of MoveL, each from the target before it, in their order."""
    moves, places = program.program.instructions, program.places
    found, current = list[list[int]](), list[int]()
    for i, move in enumerate(moves):
        if isinstance(move, Wait):
            current = current[-1:]  # it rests there, and goes on
        elif places[i].aim is None:
            current = []
        elif current and isinstance(move, MoveL) and _joined(places[current[-1]], places[i]):
            current.append(i)
            found += [current] if len(current) == 2 else []
        else:
            current = [i]
    rows = [(tuple(row), [program.program.move(i) for i in row]) for row in found]
    return [
        Row(
            moves=row,
            targets=np.array([move.to.position for move in own]),
            zones=np.array([move.zone for move in own]),
        )
        for row, own in rows
    ]


def _joined(a: Place, b: Place) -> bool:
    assert a.aim is not None and b.aim is not None  # noqa: PT018
    apart = a.aim.pose[:3, 3] - b.aim.pose[:3, 3]
    return a.tool.same(b.tool) and a.base.same(b.base) and float(np.linalg.norm(apart)) > SHORT


def arcs_of(program: ProgramText) -> dict[int, Array]:
    """Points (K, 3) [m] of each MoveC by its index, in its work object, without the zones at its
    ends."""
    found = dict[int, Array]()
    for i, move in enumerate(program.program.instructions):
        if isinstance(move, MoveC):
            place, before = program.places[i], program.places[i - 1].aim if i else None
            if before is None:
                place.text.fail(place.at, "an arc needs a position before it")
            start, end = (aim.pose[:3, 3] for aim in (before, place.aim) if aim is not None)
            try:
                found[i] = arc(start, np.array(move.via), end)
            except ValueError as error:
                place.text.fail(place.at, str(error))
    return found


def arc(start: Array, via: Array, end: Array) -> Array:
    """Points (K, 3) [m] of the circle through three points, or ValueError for points on a line."""
    a, b = via - start, end - start
    normal = np.cross(a, b)
    if (square := normal @ normal) <= 1e-18 * (a @ a) * (b @ b) or not square > 0.0:
        raise ValueError("three points of an arc must not lie on a line")
    centre = start + np.cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * square)
    x = start - centre
    y = np.cross(normal / np.sqrt(square), x)
    angle = np.mod(np.arctan2((end - centre) @ y, (end - centre) @ x), 2.0 * np.pi)
    n = int(np.ceil(angle * np.sqrt(x @ x) / STEP)) + 1
    t = np.linspace(0.0, angle, max(n, 2))[:, np.newaxis]
    return centre + np.cos(t) * x + np.sin(t) * y
