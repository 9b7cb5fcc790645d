"""Planner of motion programs: motor angles in time, with a report of the speed of each move."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array, freeze_rows
from armside.kinematics import CompiledRobot, Limits, Robot
from armside.kinematics import compile as compile_robot

from ..notes import Cause, Note
from .curves import Curve, blend, check_limits, move_curve, zone_fraction
from .instructions import Instruction, Move, Program, ProgramError, Speed, Wait
from .move_timing import PieceLimits, curve_bounds, fastest, piece_limits, time_chain
from .timing import Timing
from .tool_motion import STEP

REST_AFTER = 0.5
"""[s]."""
N_PARTS = 8
"""Parts into which a move that is limited somewhere is divided."""
PLACES = 201
"""Points of a move between two stops at which its limits are evaluated."""
SLACK = 1e-3
"""Relative difference from the programmed speed at which it counts as reached."""


@dataclass(frozen=True, kw_only=True)
class MoveReport:
    """Time and speed of one move."""

    instruction: int
    """Index in the program."""
    start: float
    end: float
    """[s]."""
    programmed: Speed
    reached: float
    """Highest tool speed [m/s], or fraction of the joints' where that was programmed."""
    limited_by: str
    """Limit that kept the move, or a part of it, below its speed; empty if none did."""


@dataclass(frozen=True, kw_only=True)
class ProgramMotion:
    """Motor angles of a program at the log rate. Row i belongs to time[i]."""

    time: Array
    """(N,) [s], from 0."""
    phi: Array
    """(N, n) [rad], arm side."""
    instruction: NDArray[np.int64]
    """(N,), index of the current instruction; that of the last one after the end."""
    reports: tuple[MoveReport, ...]

    def __post_init__(self) -> None:
        freeze_rows(self, "time", "phi", "instruction")


class _Piece(NamedTuple):
    """A curve with its limits: a move, a part of one, or the corner to the next."""

    instruction: int
    curve: Curve
    limits: PieceLimits
    corner: bool


class _Span(NamedTuple):
    """Time of a piece or, without a curve, of a wait."""

    begin: float
    instruction: int
    curve: Curve | None = None
    timing: Timing | None = None


def plan_program(
    program: Program,
    robot: Robot,
    limits: Limits,
    *,
    rest_before: float = 0.5,
) -> ProgramMotion:
    """Plan a program: geometry, corners, then the fastest timing the limits allow.

    Raises ProgramError, with the place in the program, for a target out of reach, a joint limit
    that is passed, or no circle through three points.
    """
    planner = _Planner(program, compile_robot(robot), limits)
    clock, spans, reports = rest_before, list[_Span](), list[MoveReport]()
    for chain in _chains(program.instructions):
        instruction = program.instructions[chain[0]]
        if isinstance(instruction, Wait):
            spans.append(_Span(clock, chain[0]))
            clock += instruction.seconds
            continue
        pieces, timings = planner.fastest(chain)
        reports += _reports(program, pieces, timings, clock)
        for piece, timing in zip(pieces, timings, strict=True):
            spans.append(_Span(clock, piece.instruction, piece.curve, timing))
            clock += timing.duration
    # Between spans the robot rests.
    n = int(np.ceil((clock + REST_AFTER) / STEP - 1e-9)) + 1
    time: Array = np.arange(n, dtype=np.float64) * STEP
    phi, instructions = np.tile(np.array(program.start), (n, 1)), np.zeros(n, dtype=np.int64)
    for begin, index, curve, timing in spans:
        instructions[time >= begin] = index
        if curve is not None and timing is not None:
            end = begin + timing.duration
            inside = (time >= begin) & (time <= end)
            phi[inside] = curve.at(np.clip(timing.at(time[inside] - begin)[0], 0.0, 1.0))
            phi[time > end] = curve.at(1.0)
    return ProgramMotion(time=time, phi=phi, instruction=instructions, reports=tuple(reports))


def straight_timing(program: Program, robot: Robot, limits: Limits) -> Timing:
    """Timing of a program of one MoveL, as its fraction of the way. Raises as `plan_program`."""
    pieces, timings = _Planner(program, compile_robot(robot), limits).fastest([0])
    begins = np.concatenate([[0.0], np.cumsum([timing.duration for timing in timings])])
    start, states = list[Array](), list[Array]()
    for begin, piece, timing in zip(begins[:-1], pieces, timings, strict=True):
        start.append(begin + timing.start)
        states.append((piece.curve.last - piece.curve.first) * timing.state)
        states[-1][:, 0] += piece.curve.first
    return Timing(np.concatenate(start), np.concatenate(states), float(begins[-1]))


def _chains(instructions: Sequence[Instruction]) -> list[list[int]]:
    """Indices of moves that follow without a stop; a wait is a chain of its own."""
    chains: list[list[int]] = []
    for index, (before, instruction) in enumerate(pairwise([None, *instructions])):
        running = isinstance(before, Move) and before.zone > 0.0
        if not (running and isinstance(instruction, Move)):
            chains.append([])
        chains[-1].append(index)
    return chains


@dataclass(frozen=True)
class _Planner:
    program: Program
    robot: CompiledRobot
    limits: Limits

    @cached_property
    def curves(self) -> dict[int, Curve]:
        """Whole curve of each move."""
        phi, curves = np.array(self.program.start), {}
        for index, instruction in enumerate(self.program.instructions):
            if isinstance(instruction, Wait):
                continue
            try:
                curve = move_curve(instruction, phi, self.robot, self.limits)
                check_limits(curve, self.limits)
            except ValueError as error:
                raise ProgramError(f"{self.program.place(index)}: {error}") from error
            curves[index] = curve
            phi = curve.at(1.0)
        return curves

    def fastest(self, chain: Sequence[int]) -> tuple[list[_Piece], list[Timing]]:
        """The fastest of three timings: limits constant over whole moves, constant over parts of
        those that are limited, or, between two stops, evaluated at each point.

        With the latter two a move is slow only where a joint needs it, near a singularity.
        """
        dynamics, whole = self.program.dynamics, self._pieces(chain)
        limited = any(piece.limits.limited_by for piece in whole)
        timed = [
            (p, time_chain([q.curve for q in p], [q.limits for q in p], dynamics.jerk_time))
            for p in ([whole, self._in_parts(whole)] if limited else [whole])
        ]
        if limited and len(whole) == 1:
            curve, speed = whole[0].curve, self.program.move(chain[0]).speed
            bounds = curve_bounds(curve, speed, self.robot, self.limits, dynamics, PLACES)
            timed.append((whole, [fastest(bounds, dynamics.jerk_time)]))
        return min(timed, key=lambda option: sum(timing.duration for timing in option[1]))

    def _piece(self, index: int, curve: Curve, speed: Speed, *, corner: bool = False) -> _Piece:
        limits = piece_limits(curve, speed, self.robot, self.limits, self.program.dynamics)
        return _Piece(index, curve, limits, corner)

    def _in_parts(self, pieces: Sequence[_Piece]) -> list[_Piece]:
        """Each limited move in equal parts, each with its own limits."""
        parts = []
        for piece in pieces:
            if piece.corner or not piece.limits.limited_by:
                parts.append(piece)
                continue
            speed = self.program.move(piece.instruction).speed
            ends = np.linspace(piece.curve.first, piece.curve.last, N_PARTS + 1)
            for first, last in pairwise(ends):
                curve = replace(piece.curve, first=float(first), last=float(last))
                parts.append(self._piece(piece.instruction, curve, speed))
        return parts

    def _pieces(self, chain: Sequence[int]) -> list[_Piece]:
        cut = [self.curves[index] for index in chain]
        for j, (index, following) in enumerate(pairwise(chain)):
            zone = self.program.move(index).zone
            taken = zone_fraction(self.curves[index], zone, self.robot, at_end=True)
            given = zone_fraction(self.curves[following], zone, self.robot, at_end=False)
            cut[j], cut[j + 1] = replace(cut[j], last=1.0 - taken), replace(cut[j + 1], first=given)
        pieces = []
        for j, index in enumerate(chain):
            speed = self.program.move(index).speed
            pieces.append(self._piece(index, cut[j], speed))
            if j + 1 < len(chain):
                corner = blend(cut[j], cut[j + 1])
                try:
                    check_limits(corner, self.limits)
                except ValueError as error:
                    place = self.program.place(index)
                    raise ProgramError(f"{place}, at its zone: {error}") from error
                slower = _slower(speed, self.program.move(chain[j + 1]).speed)
                pieces.append(self._piece(index, corner, slower, corner=True))
        return pieces


def _slower(a: Speed, b: Speed) -> Speed:
    """Speed through a corner: the slower of two of a kind, else the one along the path."""
    if a.path and b.path:
        return a if a.path <= b.path else b
    return min(a, b, key=lambda speed: speed.share or 0.0)


def _reports(
    program: Program, pieces: Sequence[_Piece], timings: Sequence[Timing], begun: float
) -> list[MoveReport]:
    ends = begun + np.cumsum([t.duration for t in timings])
    starts = np.concatenate([[begun], ends[:-1]])
    reports = []
    for index in dict.fromkeys(piece.instruction for piece in pieces):
        parts = [j for j, p in enumerate(pieces) if p.instruction == index and not p.corner]
        programmed = program.move(index).speed
        wanted = programmed.share or programmed.path or 0.0
        reached, slow = list[float](), list[PieceLimits]()
        for j in parts:
            limits, timing = pieces[j].limits, timings[j]
            _, ending, _ = timing.at(timing.duration * (1.0 - 1e-12))
            top = max(timing.top_speed, float(ending))
            reached.append(top / limits.full_speed if programmed.share else top * limits.tool_rate)
            if reached[-1] < wanted * (1.0 - SLACK):
                slow.append(limits)
        # Of the slowest part that has a limit; without any, the move was too short.
        named = [limits for limits in slow if limits.limited_by]
        reason = "length of the move" if len(slow) == len(parts) else ""
        if named:
            reason = min(named, key=lambda limits: limits.speed * limits.tool_rate).limited_by
        reports.append(
            MoveReport(
                instruction=index,
                start=float(starts[parts[0]]),
                end=float(ends[parts[-1]]),
                programmed=programmed,
                reached=max(reached),
                limited_by=reason,
            )
        )
    return reports


def slower_moves(motion: ProgramMotion) -> Iterator[Note]:
    """A note for each limit, with the instructions that it slows down, counted from 1."""
    limits = dict.fromkeys(report.limited_by for report in motion.reports if report.limited_by)
    for limit in limits:
        moves = [str(r.instruction + 1) for r in motion.reports if r.limited_by == limit]
        slow = f"instructions {', '.join(moves)} are slower than programmed, at least in part"
        yield Note(cause=Cause.SPEED, text=f"{slow}: {limit}")
