"""A learned correction in a person's program: other numbers for its targets, and nothing else.

The path of a row of linear moves is N(w) P (`tool_path`). Its targets are moved by the least
squares of the distance from N(w) P to the corrected path, across the path: in the plane of the
contour and along its normal. Along the path an offset does nothing at constant speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree

from armside import kinematics
from armside.arrays import Array
from armside.kinematics.rotation import from_quaternion

from ...cell import Cell
from ...motion.tool_motion import ToolMotion
from ...part.motion import PartMotion
from ...records.files import InputError
from ...robot.drives import Drives
from ...robot.servo import correction_path
from ..stored_correction import StoredCorrection
from .program_text import Aim, Place, Point, ProgramText
from .scanner import Text
from .tool_path import STEP, Row, arcs_of, nearest_across, rows_of

NEAR = 1e-3
"""Largest distance of a program from the path of the run [m]. ESTIMATE: above the chord error of
points on a contour, below the distance between contours."""
WINDOW = 3e-3
"""Along the program, in which the next place is looked for [m]. ESTIMATE"""
LARGEST_OFFSET = 5e-3
"""[m]. ESTIMATE: three times what was seen on the large robot."""
LARGEST_TURN = 0.01
"""Between the orientations of run and program [rad]. ESTIMATE"""
NOTHING = 5e-7
"""Offset that is of the least squares and of no run [m]. ESTIMATE: 0.1 um were seen."""
LONGEST = 200.0
"""[m], of all linear moves of a program."""
APART = 1.0
"""Distance of rows, so that none is followed into the next [m]."""
SUPPORT = 0.05
"""Weight of a target on the path of the run, over the largest, from which it is moved. ESTIMATE"""
LEAST_OF_ROW = 0.4
"""Part of a row's targets on the path of the run, below which it is another row. ESTIMATE"""
SPEED = 0.05
"""Relative difference of the programmed speeds of a row and of the run."""


@dataclass(frozen=True, kw_only=True)
class Corrected:
    """A program with new numbers."""

    texts: tuple[Text, ...] = field(repr=False)
    largest_offset: float
    """[m]."""
    targets: int
    """On the path of the run."""
    changed: int
    """Of them, those whose numbers changed."""
    covered: float
    """Fraction of the run's path that the program follows."""
    residual: float
    """RMS distance from the corrected path that is left [m]."""

    @property
    def line(self) -> str:
        """What a person has to know, in a line."""
        largest = f"largest offset {1e3 * self.largest_offset:.3g} mm"
        left = f"{1e6 * self.residual:.3g} µm RMS of the path are left"
        return f"{largest}; {left}; {100.0 * self.covered:.3g} % of the run's path is in it"


@dataclass(frozen=True)
class _Placed:
    """Paths of all rows as one, in base axes of TCP0."""

    rows: list[Row]
    row: NDArray[np.int64]
    """(P,), that each place belongs to."""
    w: Array
    path: Array
    """(P,), and (P, 3) [m]."""
    s: Array
    """(P,) [m], along the path; rows are `APART`."""


def corrected(
    program: ProgramText, spans: Sequence[tuple[Array, Array]], R: Array, speed: float | None = None
) -> Corrected:
    """The program on the path of a run that is moved; its other bytes as they are.

    spans: of each contour, positions (N, 3) [m] of TCP0 in base axes, as programmed and as they are
    to be. R: base to TCP0. speed: of the run, as programmed [m/s]; None is not compared.

    Raises InputError or ProgramError where the program does not follow the path, or at that speed.
    """
    even = [_by_arc_length(*span) for span in spans]
    _refuse_arcs(program, np.concatenate([run for run, _ in even]), R)
    placed = _placed_rows(program, R)
    at = [_matched(placed, run) for run, _ in even]
    goal = np.concatenate([wanted for _, wanted in even])
    index = np.concatenate(at)
    if not (used := index >= 0).any():
        name = program.program.source
        raise InputError(f"{name} has no linear moves within {1e3 * NEAR:g} mm of the run's path")
    reach = np.arange(-int(WINDOW / STEP), int(WINDOW / STEP) + 1)
    near = np.clip(index[used, np.newaxis] + reach, 0, len(placed.path) - 1)
    foot, error = nearest_across(placed.path, near, goal[used])
    N, points, turns = _basis(program, placed, foot, R)
    weight = (N.T @ N).diagonal()
    known = np.flatnonzero(weight > SUPPORT * weight.max())
    _check_rows(program, placed, points, set(known.tolist()), speed)
    offset, own = np.zeros((len(points), 3)), N[:, known]
    offset[known] = splu((own.T @ own).tocsc()).solve(own.T @ error)
    offset[np.linalg.norm(offset, axis=1) < NOTHING] = 0.0
    largest = float(np.linalg.norm(offset, axis=1).max())
    if largest > LARGEST_OFFSET:
        most = f"at most {1e3 * LARGEST_OFFSET:g} mm are allowed"
        raise InputError(f"a target would move by {1e3 * largest:.3g} mm, {most}")
    each = zip(points, offset, turns, strict=True)
    moves = {point: by @ R_base_work for point, by, R_base_work in each}
    return Corrected(
        texts=program.edited(moves),
        largest_offset=largest,
        targets=len(known),
        changed=sum(program.edits(point, by) for point, by in moves.items()),
        covered=float(used.mean()),
        residual=float(np.sqrt(np.mean(np.sum((error - N @ offset) ** 2, axis=1)))),
    )


def _check_rows(
    program: ProgramText,
    placed: _Placed,
    points: Sequence[Point],
    known: set[int],
    speed: float | None,
) -> None:
    """Raise InputError for a row of which the run's path has a few targets alone, or that moves at
    another speed."""
    index, name = {point: i for i, point in enumerate(points)}, program.program.source
    for row in placed.rows:
        aims = [aim for move in row.moves if (aim := program.places[move].aim) is not None]
        own = [index[aim.point] in known for aim in aims if aim.point in index]
        if not any(own):
            continue
        line = program.program.lines[row.moves[1]]
        if sum(own) < LEAST_OF_ROW * len(aims):
            few = f"of the {len(aims)} targets of the row from line {line} {sum(own)} lie on"
            raise InputError(f"{name}: {few} the run's path: another part, or corrected already?")
        moves = [program.program.move(i) for i in row.moves[1:]]
        speeds = [move.speed.path for move in moves if move.speed.path is not None]
        if speed and speeds and abs((median := float(np.median(speeds))) - speed) > SPEED * speed:
            text = f"the row from line {line} moves at {1e3 * median:.4g} mm/s"
            run = f"the run was programmed with {1e3 * speed:.4g}"
            raise InputError(f"{name}: {text}, {run}: a correction belongs to one speed")


def _by_arc_length(programmed: Array, goal: Array) -> tuple[Array, Array]:
    """Both at even steps along the programmed path, without rests."""
    moved = np.linalg.norm(np.diff(programmed, axis=0), axis=1)
    kept = np.concatenate([[True], moved > 1e-9])
    s = np.concatenate([[0.0], np.cumsum(moved[moved > 1e-9])])
    grid = np.linspace(0.0, s[-1], int(s[-1] / STEP) + 2)
    columns = [np.interp(grid, s, x) for x in np.hstack([programmed, goal])[kept].T]
    return np.column_stack(columns[:3]), np.column_stack(columns[3:])


def poses_of(place: Place) -> tuple[Array, Array]:
    """Of tool and work object, (4, 4). Raises ProgramError where the file lacks one."""
    for frame in (place.tool, place.base):
        if frame.pose is None:
            place.text.fail(place.at, f"the pose of {frame.name} is not in the file but needed")
    assert place.tool.pose is not None
    assert place.base.pose is not None
    return place.tool.pose, place.base.pose


def tool_in_base(place: Place, points: Array, R: Array) -> Array:
    """Points of TCP0 [m] in base axes, of a tool in its work object."""
    tool, base = poses_of(place)
    return points @ base[:3, :3].T + base[:3, 3] - R @ tool[:3, 3]


def _placed_rows(program: ProgramText, R: Array) -> _Placed:
    rows, name = rows_of(program), program.program.source
    if not rows:
        raise InputError(f"{name} has no two linear moves in a row")
    if (length := sum(float(row.spacing.sum()) for row in rows)) > LONGEST:
        most = f"at most {LONGEST:g} m are followed"
        raise InputError(f"{name} has {length:.4g} m of linear moves, {most}")
    w = [row.samples() for row in rows]
    each = zip(rows, w, strict=True)
    path = np.concatenate(
        [tool_in_base(program.places[row.moves[1]], row.path(at), R) for row, at in each]
    )
    index = np.repeat(np.arange(len(rows)), [len(at) for at in w])
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1) + APART * np.diff(index)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    return _Placed(rows, index, np.concatenate(w), path, s)


def _matched(placed: _Placed, run: Array) -> NDArray[np.int64]:
    """(K,) index of the place that each place of a run is at, in order; -1: none.

    Of several near the first, the one from which the most of the run is found.
    """
    near = np.flatnonzero(KDTree(placed.path).query(run)[0] < NEAR)
    best = np.full(len(run), -1)
    if len(near):
        distance = np.linalg.norm(placed.path - run[near[0]], axis=1)
        close = np.flatnonzero(distance < NEAR)
        for stretch in np.split(close, np.flatnonzero(np.diff(close) > 1) + 1):
            found = _tracked(placed, run, near, int(stretch[distance[stretch].argmin()]))
            best = found if (found >= 0).sum() > (best >= 0).sum() else best
    return best


def _tracked(placed: _Placed, run: Array, near: NDArray[np.int64], now: int) -> NDArray[np.int64]:
    found = np.full(len(run), -1)
    for k in near:
        low, high = np.searchsorted(placed.s, [placed.s[now] - STEP, placed.s[now] + WINDOW])
        distance = np.linalg.norm(placed.path[low:high] - run[k], axis=1)
        if distance.min() < NEAR:
            now = found[k] = int(low + distance.argmin())
    return found


def _basis(
    program: ProgramText, placed: _Placed, foot: NDArray[np.int64], R: Array
) -> tuple[csc_array, list[Point], list[Array]]:
    """N (K, M) of places in all rows, the M points, and from base to work object of each."""
    index, turns, parts = dict[Point, int](), list[Array](), list[tuple[NDArray[Any], ...]]()
    for i, row in enumerate(placed.rows):
        places = [program.places[move] for move in row.moves]
        if len(own := np.flatnonzero(placed.row[foot] == i)) == 0:
            continue
        aims = [place.aim for place in places if place.aim is not None]
        for place, aim in zip(places, aims, strict=True):
            check_target(place, aim, aims[0], R)
            if aim.point not in index:
                index[aim.point] = len(index)
                turns.append(poses_of(place)[1][:3, :3])
        N = row.basis(placed.w[foot[own]]).tocoo()
        columns = np.array([index[aim.point] for aim in aims])
        parts.append((N.data, own[N.coords[0]], columns[N.coords[1]]))
    data, rows, columns = (np.concatenate(part) for part in zip(*parts, strict=True))
    shape = (len(foot), len(index))
    return csc_array((data, (rows, columns)), shape=shape), list(index), turns


def check_target(place: Place, aim: Aim, first: Aim, R: Array) -> None:
    """Refuse a target whose orientation is not that of the run, or external axes that move."""
    tool, base = poses_of(place)
    turned = base[:3, :3] @ aim.pose[:3, :3] @ tool[:3, :3].T
    angle = float(np.linalg.norm(turned - R)) / np.sqrt(2.0)  # of small ones
    if angle > LARGEST_TURN:
        text = f"the orientation is {np.degrees(angle):.3g} deg from that of the run"
        place.text.fail(place.at, text)
    if aim.external != first.external:
        place.text.fail(place.at, "external axes move along the path of the run")


def _refuse_arcs(program: ProgramText, run: Array, R: Array) -> None:
    """An arc has three points, which cannot take a correction along it."""
    for i, points in arcs_of(program).items():
        place = program.places[i]
        away = KDTree(run).query(tool_in_base(place, points, R))[0]
        if np.median(away) < NEAR:
            reason = "an arc cannot take a correction: write it as short linear moves"
            place.text.fail(place.at, reason)


def corrected_by(
    program: ProgramText,
    motion: ToolMotion | PartMotion,
    stored: StoredCorrection,
    cell: Cell,
    drives: Drives,
    speed: float | None = None,
) -> Corrected:
    """The program on the path r + u of a run, u delayed and lagged as by the servo's input."""
    period, delay, lag = stored.sample_time, drives.correction_delay, drives.correction_lag
    u = correction_path(stored.correction, period, 1, delay, lag).position
    pose, r = kinematics.compile(cell.robot).pose, stored.reference
    moved, at = (pose(np.ascontiguousarray(phi))[:, :3, 3] for phi in (r + u, r))
    return displaced(program, motion, moved - at, speed)


def displaced(
    program: ProgramText,
    motion: ToolMotion | PartMotion,
    displacement: Array,
    speed: float | None = None,
) -> Corrected:
    """The program on a motion's path that is displaced by (N, 3) [m]. speed, raises: as
    `corrected`."""
    programmed, time = motion.position, motion.time
    masks = [np.ones(len(time), dtype=bool)]
    if isinstance(motion, PartMotion):
        masks = [(time >= cut.start) & (time <= cut.end) for cut in motion.cuts]
    spans = [(programmed[m], (programmed + displacement)[m]) for m in masks]
    return corrected(program, spans, from_quaternion(motion.quaternion[0]), speed)
