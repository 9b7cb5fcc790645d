"""Virtual controllers that take programs: rows of linear moves, run by a robot of ours.

The path of a row is `Row.path` with the controller's corner. Its speed is that of the plan, block
for block: a block that targets made longer takes longer. So runs differ in length, and each has the
time of the plan at which it is at the same place, `ProgramRun.plan_time`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from armside.arrays import Array
from armside.kinematics import UnreachableError
from armside.kinematics.inverse.closed_form import JointRangeError

from ...laser.experiment import CuttingPlant, Experiment, Pass
from ...laser.joint_bounds import out_of_reach
from ...motion.path import Plane
from ...motion.timing import Timing
from ...motion.tool_motion import joint_reference
from ...part.arcs import place
from ...part.motion import PartMotion
from ...robot.statics import Statics, anticipated_shift, smoothed
from ...robot.virtual_robot import LOG_PERIOD, VirtualRobot
from .new_program import CLOSE, contour_in_base, fitted
from .tool_path import Corner, Row, arc_lengths

FINE = 2e-5
"""Between samples of a path [m]: their chords are off by 1e-8 m on a radius of 5 mm."""
TICK = 5e-4
"""Between samples of a plan [s]."""
STEADY = 0.99
"""Least speed of a plan over its top speed, by which a run's pace is told."""
REST_AFTER = 0.35
"""[s], as of a cut."""


@dataclass(frozen=True, kw_only=True)
class Interpolator:
    """How a controller follows a row of targets. All of it is assumed: no maker publishes it."""

    corner: Corner = "parabola"
    dip: float = 0.0
    """Fraction of the speed that is lost at each target."""
    block_time: float = 0.0
    """Least time of a block [s]."""
    look_ahead: int = 0
    """Blocks within which it can stop at any time, by `acceleration`; 0 for no such limit."""
    acceleration: float = 1.3
    """[m/s^2], as `PathLimits`."""
    cycle: float = LOG_PERIOD
    """Between set points [s], which it joins by straight lines."""
    single: bool = False
    """Targets are rounded to single precision of a millimetre."""


ASSUMED = Interpolator()
"""Parabolas and the programmed speed."""
VIRTUAL: Mapping[str, Interpolator] = {
    "quintic corners": Interpolator(corner="quintic"),
    "sharp corners, 10 % dips": Interpolator(corner="sharp", dip=0.1),
    "30 % dips": Interpolator(dip=0.3),
    "look-ahead of three blocks of at least 12 ms": Interpolator(look_ahead=3, block_time=0.012),
    "set points each 12 ms, single precision": Interpolator(cycle=0.012, single=True),
}
"""Other controllers than the assumed one."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """One row of targets in the plan, from rest to rest."""

    row: Row
    """Targets [m] of TCP0 in base axes."""
    point: Callable[[Array], Array] = field(repr=False)
    """Points (K, 3) [m] of the contour, leads included, at arc lengths [m]."""
    length: float
    """[m]."""
    timing: Timing
    start: float
    """[s]."""
    frame: Array = field(repr=False)
    """(M, 2, 3): directions that a target moves in, across the path and along the normal."""

    @classmethod
    def of(
        cls,
        row: Row,
        point: Callable[[Array], Array],
        length: float,
        timing: Timing,
        start: float,
        plane: Plane,
    ) -> "Stretch":
        """With targets that move across the path, in the plane and out of it."""
        normal = plane.axes[:, 2]
        across = np.cross(normal, np.gradient(row.targets, axis=0))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        frame = np.stack([across, np.broadcast_to(normal, across.shape)], axis=1)
        return cls(row, point, length, timing, start, frame)

    def arc_length(self, time: Array) -> Array:
        """Of the contour [m] at times of the plan [s]."""
        return np.clip(self.timing.at(time - self.start)[0], 0.0, self.length)

    def during(self, time: Array) -> NDArray[np.bool_]:
        """Times of the plan [s] from its start to its end."""
        return (time >= self.start) & (time <= self.start + self.timing.duration)


@dataclass(frozen=True, kw_only=True, eq=False)
class ProgramRun:
    """Reference of one run of a program."""

    reference: Array
    """(K, n) [rad]."""
    run_time: Array
    plan_time: Array
    """(P,) [s], the run and the plan at the same places."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlannedProgram:
    """A program for the contours of an experiment, whose targets can be moved.

    Its inputs are displacements of the path (N, 3) [m] at the instants of the plan: N(w) times the
    offsets of the targets. The first and the last target of a row stay.
    """

    experiment: Experiment[Any]
    stretches: tuple[Stretch, ...]
    interpolator: Interpolator = ASSUMED
    apart: bool = False
    """Zones may not meet, as of URScript."""

    @classmethod
    def of(
        cls, experiment: Experiment[Any], spacing: float, *, apart: bool = False
    ) -> "PlannedProgram":
        """With targets at most `spacing` [m] apart."""
        motion = experiment.motion
        if isinstance(motion, PartMotion):
            each = [
                (contour_in_base(motion, cut), cut.path.length, cut.timing, cut.start)
                for cut in motion.cuts
            ]
        else:
            path = motion.path
            each = [(path.position, path.length, motion.timing, motion.rest_before)]
        found = [
            Stretch.of(
                fitted(point, length, spacing)[0], point, length, timing, start, motion.plane
            )
            for point, length, timing, start in each
        ]
        return cls(experiment=experiment, stretches=tuple(found), apart=apart)

    @cached_property
    def basis(self) -> csc_array:
        """(N, M), displacement of the path at each instant of the plan for offsets of targets."""
        time, blocks = self.experiment.motion.time, list[Array]()
        for stretch in self.stretches:
            w = stretch.row.samples(FINE)
            along = arc_lengths(stretch.row.path(w))
            share = stretch.arc_length(time) / stretch.length
            block = stretch.row.basis(np.interp(share * along[-1], along, w))
            blocks.append(stretch.during(time)[:, np.newaxis] * block.toarray())
        return csc_array(np.concatenate(blocks, axis=1))

    @property
    def ends(self) -> list[int]:
        """First target of each stretch among all, and their number."""
        return np.cumsum([0, *(len(each.row.targets) for each in self.stretches)]).tolist()

    @cached_property
    def free(self) -> np.ndarray:
        """(F,) targets that may move."""
        each = [np.arange(a + 1, b - 1) for a, b in zip(self.ends, self.ends[1:], strict=False)]
        return np.concatenate(each)

    def offsets(self, displacement: Array) -> Array:
        """(M, 3) [m] of the targets, whose path is displaced by (N, 3)."""
        own = self.basis[:, self.free]
        found = np.zeros((self.ends[-1], 3))
        found[self.free] = splu((own.T @ own).tocsc()).solve(own.T @ displacement)
        return found

    def is_steady(self, time: Array) -> NDArray[np.bool_]:
        """Times of the plan [s] at which a row has at least `STEADY` of its speed."""
        found = np.zeros(len(time), dtype=bool)
        for stretch in self.stretches:
            speed = stretch.timing.at(time - stretch.start)[1]
            found |= speed >= STEADY * stretch.timing.top_speed
        return found

    def pace(self, clock: tuple[Array, Array]) -> float:
        """Time of a run over that of the plan: of a block in the median, where the plan is steady.

        clock: times (P,) [s] of run and plan at the same places.
        """
        plan = np.arange(0.0, self.experiment.motion.motion_end, TICK)
        ran, steady = np.interp(plan, clock[1], clock[0]), self.is_steady(plan)
        block = max(s.row.spacing.mean() / s.timing.top_speed for s in self.stretches)
        n = max(round(block / TICK), 1)
        both = steady[n:] & steady[:-n]
        return float(np.median((ran[n:] - ran[:-n])[both]) / (n * TICK)) if both.any() else 1.0

    def rows(self, offsets: Array) -> list[Row]:
        """Rows with moved targets."""
        parts = np.split(offsets, self.ends[1:-1])
        each = zip(self.stretches, parts, strict=True)
        rows = [replace(s.row, targets=s.row.targets + by) for s, by in each]
        if not self.apart:
            return rows
        zone = CLOSE * min(float(row.spacing.min()) for row in rows)
        return [replace(row, zones=np.full(len(row.targets), zone)) for row in rows]

    @cached_property
    def controller(self) -> Statics:
        return Statics(self.experiment.nominal)

    def run(self, rows: Sequence[Row]) -> ProgramRun:
        """The reference that the controller makes of rows of targets, one for each stretch."""
        motion, cut = self.experiment.motion, self.experiment.cut
        plan = np.arange(0.0, motion.motion_end + TICK, TICK)
        paths = [self._path(s, row) for s, row in zip(self.stretches, rows, strict=True)]
        plan = np.union1d(plan, np.concatenate([path.knots for path in paths]))
        middle, slower = 0.5 * (plan[1:] + plan[:-1]), np.ones(len(plan) - 1)
        for path in paths:
            path.slow(slower, middle)
        run_time = np.concatenate([[0.0], np.cumsum(slower * np.diff(plan))])
        cycle = self.interpolator.cycle
        n = int(np.ceil((run_time[-1] + REST_AFTER) / LOG_PERIOD)) + 1
        time = np.arange(n, dtype=np.float64) * LOG_PERIOD
        points = np.arange(0.0, time[-1] + cycle, cycle)
        at = np.interp(points, run_time, plan)
        position = motion.position_at(at)
        for path in paths:
            path.place(position, at)
        position = np.stack([np.interp(time, points, column) for column in position.T], axis=1)
        moved = _Positions(position, np.tile(motion.quaternion[0], (n, 1)))
        robot, limits, free = cut.cell.robot, cut.cell.limits, cut.cell.free_rotation
        start = self.experiment.loaded.reference[0]
        try:
            phi = joint_reference(moved, robot, limits, start=start, free_rotation=free)
            shift = smoothed(anticipated_shift(self.controller, phi, LOG_PERIOD))
            reference = joint_reference(
                moved, robot, limits, start=phi[0], shift=shift, free_rotation=free
            )
        except (UnreachableError, JointRangeError) as error:
            planned = motion.position_at(np.interp(time[error.index], points, at))
            raise out_of_reach(error, where(motion, planned), robot) from error
        return ProgramRun(reference=reference, run_time=run_time, plan_time=plan)

    def _path(self, stretch: Stretch, row: Row) -> "_Path":
        how = self.interpolator
        if how.single:
            rounded = np.asarray(1e3 * row.targets, np.float32).astype(np.float64) / 1e3
            row = replace(row, targets=rounded)
        found = list[tuple[Array, Array, Array]]()
        for each in (stretch.row, row):
            w = each.samples(FINE)
            path = each.path(w, how.corner)
            middles = np.concatenate([[0.0], np.arange(1.5, each.n_pieces, 2.0), [w[-1]]])
            s = arc_lengths(path)
            found.append((path, s, np.interp(middles, w, s)))
        (_, was, knots), (path, s, ends) = found
        lengths, speed = np.diff(ends), stretch.timing.top_speed
        most = np.inf if not how.look_ahead else np.sqrt(2.0 * how.acceleration * how.look_ahead)
        time = lengths / np.minimum(speed, most * np.sqrt(lengths))
        slower = lengths / np.diff(knots) * (np.maximum(time, how.block_time) * speed / lengths)
        return _Path(stretch, stretch.length / was[-1] * knots, ends, slower, how.dip, s, path)


def where(motion: Any, position: Array) -> str:
    """A place in the drawing, or in base axes where there is none."""
    if isinstance(motion, PartMotion):
        return place(motion.plane.from_base(position)[:2] + np.array(motion.middle))
    return "({:.1f}, {:.1f}, {:.1f}) mm".format(*(1e3 * position))


@dataclass(frozen=True, eq=False)
class _Path:
    """A row on its way: blocks from the middle of a corner to that of the next."""

    stretch: Stretch
    planned: Array
    """(B + 1,) [m], ends of the blocks on the contour."""
    ends: Array
    """(B + 1,) [m], on the path."""
    slower: Array
    """(B,), time of each block over that of the plan."""
    dip: float
    s: Array
    position: Array
    """(K,) and (K, 3) [m], the path."""

    @cached_property
    def knots(self) -> Array:
        """(B + 1,) [s], of the plan, at the ends of the blocks."""
        timing = self.stretch.timing
        time: Array = np.linspace(0.0, timing.duration, int(timing.duration / 1e-4) + 2)
        return self.stretch.start + np.interp(self.planned, timing.at(time)[0], time)

    def slow(self, slower: Array, time: Array) -> None:
        """Set the time over that of the plan at times (P,) of the plan [s]."""
        inside = (time > self.knots[0]) & (time < self.knots[-1])
        block = np.searchsorted(self.planned, s := self.stretch.arc_length(time[inside])) - 1
        block = np.clip(block, 0, len(self.slower) - 1)
        x = (s - self.planned[block]) / np.diff(self.planned)[block]
        slower[inside] = self.slower[block] / (1.0 - self.dip * np.cos(np.pi * x) ** 2)

    def place(self, position: Array, time: Array) -> None:
        """Set the positions (K, 3) at those times (K,) of the plan [s] that are on it."""
        inside = (time >= self.knots[0]) & (time <= self.knots[-1])
        at = np.interp(self.stretch.arc_length(time[inside]), self.planned, self.ends)
        columns = [np.interp(at, self.s, column) for column in self.position.T]
        position[inside] = np.stack(columns, axis=1)


@dataclass(frozen=True)
class _Positions:
    position: Array
    quaternion: Array


@dataclass(frozen=True)
class ProgramPlant(CuttingPlant):
    """Plant of a learning loop that runs a program: corrections are displacements of its path."""

    program: PlannedProgram = field(kw_only=True)

    @classmethod
    def of(cls, program: PlannedProgram) -> "ProgramPlant":
        """The robot and the instruments of the program's experiment."""
        plant = program.experiment.plant
        return cls(plant.loaded, plant.tracker, plant.rng, plant.imu, program=program)

    def run(self, correction: Array, /) -> Pass:
        """Run the program with its path displaced by (N, 3) [m]."""
        program = self.program
        asked = program.run(program.rows(program.offsets(correction)))
        robot = VirtualRobot(self.loaded.model, nominal=program.controller)
        plant = CuttingPlant(robot.load(asked.reference), self.tracker, self.rng, self.imu)
        found = plant.run(np.zeros_like(asked.reference))
        return replace(found, clock=(asked.run_time, asked.plan_time))
