"""A person's program as an experiment: the tool is to follow what the program's own targets draw.

Rows of short linear moves from stop to stop are learned, each at its constant speed. Straight moves
stand for what leads from one to the next.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from armside.arrays import Array
from armside.kinematics.rotation import to_quaternion

from ...evaluation.tool_error import ToolError
from ...laser.experiment import prepare
from ...laser.specification import Ended, Setup, Timed
from ...laser.specification import Row as Entries
from ...motion.path import Plane
from ...motion.timing import PathLimits, Timing, rest_to_rest
from ...motion.tool_motion import STEP, LimitHit, joint_reference
from ...notes import Note
from ...part.motion import on_grid, samples_until
from ...records.files import InputError
from ...robot.statics import Statics, anticipated_shift, smoothed
from ...robot.virtual_robot import LOG_PERIOD
from .correction import check_target, poses_of, tool_in_base
from .program_text import Aim, Point, ProgramText
from .tool_path import SHORT, Row, arc_lengths, nearest_across, rows_of
from .virtual_run import FINE, REST_AFTER, PlannedProgram, Stretch

LEAST = 4
"""Targets of a row that is learned, whose first and last stay."""
REST_BEFORE = 0.28
"""[s], as of a cut."""
BETWEEN, PAUSE = 0.1, 0.1
"""Speed [m/s] of a straight move to the next row, and rest before it is cut [s]. ESTIMATES"""
LONGEST = 300.0
"""[s], of all rows: each run of a model takes about as long."""
FITS = 20
"""Steps of the fit of a row's place."""
FLAT = 1e-3
"""Width of targets over their length, below which they lie on a line and in no plane."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Leg:
    """A row of targets of TCP0 in base axes, from rest to rest."""

    row: Row
    timing: Timing
    start: float
    """[s]."""
    learned: bool = True

    @cached_property
    def path(self) -> Array:
        """(K, 3) [m]."""
        return self.row.path(self.row.samples(FINE))

    @cached_property
    def s(self) -> Array:
        """(K,) [m], along the path."""
        return arc_lengths(self.path)

    @property
    def end(self) -> float:
        """[s]."""
        return self.start + self.timing.duration

    def point(self, s: Array | float) -> Array:
        """Points (..., 3) [m] at arc lengths [m]."""
        return np.stack([np.interp(s, self.s, column) for column in self.path.T], axis=-1)

    @property
    def cruise(self) -> tuple[float, float]:
        """Start and end of its constant speed [s]."""
        first, last = self.timing.cruise
        return self.start + first, self.start + last


@dataclass(frozen=True, kw_only=True, eq=False)
class ProgramMotion:
    """Motion of the tool along the rows of a program, at rest at both ends."""

    legs: tuple[Leg, ...]
    plane: Plane
    tool_quaternion: tuple[float, float, float, float]
    """Base to TCP0."""
    rest_before: float = REST_BEFORE
    limits_hit: tuple[LimitHit, ...] = ()

    @property
    def learned(self) -> tuple[Leg, ...]:
        return tuple(leg for leg in self.legs if leg.learned)

    @cached_property
    def time(self) -> Array:
        """(N,) [s], from 0."""
        last = samples_until(self.legs, REST_AFTER, STEP)  # pyright: ignore[reportArgumentType]
        return np.arange(last, dtype=np.float64) * STEP

    @property
    def position(self) -> Array:
        """(N, 3) [m], base axes."""
        return self._position

    @cached_property
    def _position(self) -> Array:
        return self.position_at(self.time)

    @property
    def quaternion(self) -> Array:
        """(N, 4), base to tool."""
        return np.tile(self.tool_quaternion, (len(self.time), 1))

    @property
    def motion_end(self) -> float:
        """[s]."""
        return self.legs[-1].end

    def position_at(self, time: ArrayLike) -> Array:
        """Programmed tool position (..., 3) [m] at any times [s]."""
        time = np.asarray(time, dtype=np.float64)
        found = np.broadcast_to(self.legs[0].point(0.0), (*time.shape, 3)).copy()
        for leg in self.legs:
            own = time >= leg.start
            found[own] = leg.point(leg.timing.at(time[own] - leg.start)[0])
        return found

    def is_on_contour(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Mask of the times [s] at constant speed on a row."""
        time = np.asarray(time, dtype=np.float64)
        spans = [leg.cruise for leg in self.learned]
        return np.any([(time >= first) & (time < last) for first, last in spans], axis=0)


@dataclass(frozen=True, kw_only=True)
class ProgramCut(Setup[ProgramMotion]):
    """What a program cuts, by one robot individual."""

    program: ProgramText = field(repr=False)
    home: tuple[float, ...] | None = None
    """Motor angles [rad] near its start; those of the cell if None."""

    @cached_property
    def motion(self) -> ProgramMotion:
        """Raises ProgramError or InputError for a program without rows that can be learned."""
        return _motion(self.program, self.limits)

    def planned(self, nominal: Statics) -> tuple[ProgramMotion, Array]:
        cell, motion = self.cell, self.motion
        start = cell.home if self.home is None else self.home
        phi = joint_reference(motion, cell.robot, cell.limits, start=start)
        shift = smoothed(anticipated_shift(nominal, phi, LOG_PERIOD))
        return motion, joint_reference(motion, cell.robot, cell.limits, start=phi[0], shift=shift)

    def errors(
        self, motion: ProgramMotion, time: Array, position: Array, *, edges: bool = True
    ) -> tuple[ToolError, ...]:
        """Distances from the rows, which are moved to fit, as those of any contour are."""
        found = list[ToolError]()
        for leg in motion.learned:
            first, last = leg.cruise
            seen = position[(time >= first) & (time < last)]
            path, rms, most = motion.plane.from_base(seen)[:, :2], np.nan, np.nan
            if len(seen) and np.isfinite(seen).all():
                tree, away, shift = KDTree(leg.path), seen, np.zeros(3)
                for _ in range(FITS):
                    foot = np.asarray(tree.query(seen - shift)[1])[:, np.newaxis]
                    away = nearest_across(leg.path, foot, seen - shift)[1]
                    shift = shift + away.mean(axis=0)
                size = np.linalg.norm(away, axis=1)
                rms, most = float(np.sqrt(np.mean(size**2))), float(size.max())
            found.append(ToolError(rms=rms, maxdev=most, path=path))
        return tuple(found)

    def whole(self, motion: ProgramMotion, errors: Sequence[ToolError]) -> ToolError:
        length = [leg.s[-1] for leg in motion.learned]
        squares = [error.rms**2 for error in errors]
        return ToolError(
            rms=float(np.sqrt(np.average(squares, weights=length))),
            maxdev=max(error.maxdev for error in errors),
            path=np.concatenate([error.path for error in errors]),
        )

    def contours(self, motion: ProgramMotion) -> Sequence[Timed]:
        return [Timed(f"row {i}", *leg.cruise) for i, leg in enumerate(motion.learned, start=1)]

    def weights(self, motion: ProgramMotion) -> Array:
        return np.ones((len(motion.time), 1))

    def notes(self, motion: ProgramMotion) -> Iterator[Note]:
        return iter(())

    def entries(
        self, motion: ProgramMotion, contours: Sequence[Sequence[Entries]], ends: Sequence[Ended]
    ) -> Entries:
        return {}


def fitted_rms(motion: ProgramMotion, error: Array) -> float:
    """RMS [m] of an error across the path (N, 3) [m] and in its plane, its rows moved to fit as by
    `errors`."""
    up = motion.plane.axes[:, 2]
    tangent, left = np.gradient(motion.position, axis=0), list[Array]()
    for leg in motion.learned:
        on = (motion.time >= leg.cruise[0]) & (motion.time < leg.cruise[1])
        t = tangent[on] / np.linalg.norm(tangent[on], axis=1, keepdims=True)
        across = np.eye(3) - np.outer(up, up) - t[:, :, np.newaxis] * t[:, np.newaxis, :]
        e = np.einsum("kij,kj->ki", across, error[on])
        shift = np.linalg.lstsq(across.sum(axis=0), e.sum(axis=0), rcond=1e-6)[0]
        left.append(e - across @ shift)
    return float(np.sqrt(np.mean(np.sum(np.concatenate(left) ** 2, axis=1))))


def own_program(cut: ProgramCut, *, seed: int = 0) -> PlannedProgram:
    """The program of a cut, whose targets can be moved. Raises as `prepare` and `ProgramCut`."""
    experiment: Any = prepare(cut, seed=seed)
    motion: ProgramMotion = experiment.motion
    found = tuple(
        Stretch.of(leg.row, leg.point, float(leg.s[-1]), leg.timing, leg.start, motion.plane)
        for leg in motion.learned
    )
    return PlannedProgram(experiment=experiment, stretches=found)


def text_of(program: PlannedProgram) -> ProgramText:
    """Text of an own program."""
    cut = program.experiment.cut
    assert isinstance(cut, ProgramCut)
    return cut.program


def moved_points(program: PlannedProgram, offsets: Array) -> dict[Point, Array]:
    """Points of an own program's text with their steps (3,) [m], in their work objects, of offsets
    (M, 3) [m] of its targets."""
    text, found = text_of(program), dict[Point, Array]()
    moves = [move for stretch in program.stretches for move in stretch.row.moves]
    for i in program.free:
        place = text.places[moves[i]]
        assert place.aim is not None
        found[place.aim.point] = offsets[i] @ poses_of(place)[1][:3, :3]
    return found


def _motion(program: ProgramText, limits: PathLimits) -> ProgramMotion:
    rows, name = list(_rows(program)), program.program.source
    if not rows:
        needed = f"{LEAST} linear moves or more between two stops, with zones"
        raise InputError(f"{name} has no row that can be learned: it needs {needed}")
    R, legs, clock = _orientation(program, rows), list[Leg](), REST_BEFORE
    for row, speed in rows:
        placed = replace(row, targets=tool_in_base(program.places[row.moves[1]], row.targets, R))
        if legs and np.linalg.norm(placed.targets[0] - legs[-1].row.targets[-1]) > SHORT:
            ends = np.stack([legs[-1].row.targets[-1], placed.targets[0]])
            line = Row(moves=(0, 1), targets=ends, zones=np.zeros(2))
            length = float(line.spacing.sum())
            timing = rest_to_rest(length, BETWEEN, limits)
            legs.append(Leg(row=line, timing=timing, start=clock, learned=False))
            clock = on_grid(legs[-1].end + PAUSE, STEP)
        length = float(arc_lengths(placed.path(placed.samples(FINE)))[-1])
        legs.append(Leg(row=placed, timing=rest_to_rest(length, speed, limits), start=clock))
        clock = on_grid(legs[-1].end, STEP)
    if clock > LONGEST:
        raise InputError(f"{name} takes {clock:.4g} s, at most {LONGEST:g} s are learned")
    w, x, y, z = to_quaternion(R).tolist()
    return ProgramMotion(legs=tuple(legs), plane=_plane(legs), tool_quaternion=(w, x, y, z))


def _rows(program: ProgramText) -> Iterator[tuple[Row, float]]:
    """Rows that are learned, in their work objects, and the speed of each [m/s]."""
    ends = [place.aim.point for place in program.places if place.aim is not None]
    for row in rows_of(program):
        stops = [0, *(np.flatnonzero(row.zones[1:-1] == 0.0) + 1), len(row.targets) - 1]
        for a, b in pairwise(stops):
            own = slice(a, b + 1)
            if b - a + 1 < LEAST:
                continue
            made = Row(
                moves=row.moves[own], targets=row.targets[own].copy(), zones=row.zones[own].copy()
            )
            speeds = [program.program.move(i).speed.path or 0.0 for i in made.moves[1:]]
            for i, speed in zip(made.moves[1:-1], speeds, strict=False):
                place = program.places[i]
                if speed != speeds[-1]:
                    both = f"{1e3 * speed:g} and {1e3 * speeds[-1]:g} mm/s"
                    place.text.fail(place.at, f"a row that is learned has one speed, not {both}")
                if place.aim is not None and ends.count(place.aim.point) > 1:
                    shared = "is the end of more than one move: give each a target of its own"
                    place.text.fail(place.at, f"its target {shared}")
            yield made, speeds[-1]


def _orientation(program: ProgramText, rows: Sequence[tuple[Row, float]]) -> Array:
    """(3, 3), base to TCP0, of all their targets. Raises ProgramError for another one."""
    places = [program.places[i] for row, _ in rows for i in row.moves]
    aims = [place.aim for place in places if place.aim is not None]
    first: Aim = aims[0]
    tool, base = poses_of(places[0])
    R = base[:3, :3] @ first.pose[:3, :3] @ tool[:3, :3].T
    for place, aim in zip(places, aims, strict=True):
        check_target(place, aim, first, R)
    return R


def _plane(legs: Sequence[Leg]) -> Plane:
    """Plane of the targets; of those on a line, the one that is most nearly level."""
    points = np.concatenate([leg.row.targets for leg in legs if leg.learned])
    middle = points.mean(axis=0)
    _, size, axes = np.linalg.svd(points - middle)
    normal = axes[2]
    if size[1] < FLAT * size[0]:
        up = np.eye(3)[2 if abs(axes[0, 2]) < 0.9 else 0]
        normal = up - (up @ axes[0]) * axes[0]
    return Plane.perpendicular_to(normal, middle)
