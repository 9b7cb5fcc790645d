"""A part cut in one run: rest, and for each contour a rapid move, piercing and its cut."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.kinematics import UnreachableError
from armside.kinematics.inverse.closed_form import JointRangeError

from ..evaluation.contour_error import ContourError, contour_errors
from ..evaluation.kerf import kerf
from ..evaluation.tool_error import ToolError
from ..instruments.laser_tracker import TrackerSamples
from ..instruments.noise import rate_of, stride
from ..motion.instructions import Dynamics, MoveL, Program, Speed, Target
from ..motion.planner import straight_timing
from ..motion.tool_motion import joint_reference
from ..notes import Cause, Note
from ..part.arcs import Chain, place
from ..part.motion import ContourPlace, CutLeg, Leg, PartMotion, on_grid, samples_until
from ..part.part import Part
from ..part.plan import Cutting, Plan, plan, rapid_moves
from ..records.signals import RecordedRun
from ..robot.kinematics_check import cell_model
from ..robot.statics import Statics, anticipated_shift, smoothed
from ..robot.virtual_robot import LOG_PERIOD
from .experiment import Iteration, controlled
from .joint_bounds import JointBounds, motors_at, out_of_reach
from .results import named
from .specification import Ended, Row, Setup, Timed

NOWHERE = 1e-6
"""Length of a move that is none [m]."""
REST_BEFORE, REST_AFTER = 0.28, 0.35
"""[s], as of a single cut."""
SHORTEST_BLEND = 0.1
"""Time in which one contour's correction becomes that of the next, at least [s]. ESTIMATE"""
EXCESS = 0.01
"""Relative excess of a joint's speed limit between the places at which a plan looks at it."""
REACHED = 0.999
"""Fraction of the programmed speed that counts as reached."""


class JointSpeedError(ValueError):
    """A joint would be faster than its limit."""


@dataclass(frozen=True, kw_only=True)
class PartCut(Setup[PartMotion]):
    """All contours of a part, its middle at the pose, cut in one run. SI units."""

    part: Part = field(repr=False)
    cutting: Cutting = field(default_factory=Cutting)

    @cached_property
    def plan(self) -> Plan:
        """Within the limits of the robot's joints and drives.

        Raises ValueError where the part leaves the reach or the joint limits (where), or the beam
        is too wide.
        """
        controller = Statics(controlled(self, cell_model(self.cell, self.model)))
        bounds = JointBounds(self, controller, self.plane, self.part.middle, self.cutting.speed)
        return plan(self.part, self.cutting, bounds.along)

    def plan_entries(self) -> Row:
        """Entries of the `summary.json` of a part that is only planned. SI units."""
        found = self.plan
        contours = [
            {
                "name": cut.contour.name,
                "kind": cut.contour.kind,
                "length": cut.path.length - 2.0 * cut.lead,
                "asked_speed": self.cutting.speed,
                "reached_speed": cut.reached_speed,
                "seconds": cut.seconds,
                "iterations": [],
            }
            for cut in found.cuts
        ]
        return {"seconds": found.seconds, "contours": contours, "notes": list(plan_notes(found))}

    @cached_property
    def motion(self) -> PartMotion:
        """Of the tool, which starts at the lower left corner of the part's box."""
        legs, (a, b) = tuple(self._legs()), map(float, self.part.middle)
        return PartMotion(
            legs=legs,
            plane=self.plane,
            middle=(a, b),
            tool_quaternion=self.tool_pose.quaternion,
            n_samples=samples_until(legs, REST_AFTER, LOG_PERIOD),
            step=LOG_PERIOD,
            rest_before=REST_BEFORE,
        )

    def _legs(self) -> Iterator[Leg]:
        moves, clock, cell, cutting = rapid_moves(self.plan), REST_BEFORE, self.cell, self.cutting
        placed = self.plane.to_base(moves - self.part.middle)
        phi, most = motors_at(self, placed[:, 0], moves[:, 0]), self.limits.acceleration
        dynamics = Dynamics(path_acceleration=most, jerk_time=most / self.limits.jerk)
        for cut, ends, tool, motors in zip(self.plan.cuts, moves, placed, phi, strict=True):
            length = float(np.linalg.norm(tool[1] - tool[0]))
            if length >= NOWHERE:
                there = MoveL(to=Target(position=tuple(tool[1])), speed=Speed(path=cutting.rapid))
                rapid = Program(
                    instructions=(there,),
                    start=tuple(motors),
                    dynamics=dynamics,
                    source="rapid move",
                )
                timing = straight_timing(rapid, cell.robot, cell.limits)
                timing = replace(timing, state=length * timing.state)
                yield Leg(path=Chain(ends, np.zeros(1)), timing=timing, start=clock)
                clock = on_grid(clock + timing.duration, LOG_PERIOD)
            clock = on_grid(clock + cutting.pierce, LOG_PERIOD)
            leg = CutLeg(
                path=cut.path,
                timing=cut.profile.timing,
                start=clock,
                name=cut.contour.name,
                kind=cut.contour.kind,
                lead=cut.lead,
                asked_speed=cutting.speed,
            )
            yield leg
            clock = on_grid(leg.end, LOG_PERIOD)

    def planned(self, nominal: Statics) -> tuple[PartMotion, Array]:
        return self.motion, reference(self, nominal, self.motion)

    def errors(
        self, motion: PartMotion, time: Array, position: Array, *, edges: bool = True
    ) -> tuple[ContourError, ...]:
        """At the log rate: a part is long, and its errors are slow."""
        every = max(round(rate_of(time) * LOG_PERIOD), 1)  # a program has a clock of its own
        beam = self.cutting.beam if edges else None
        return contour_errors(motion, time[::every], position[::every], beam)

    def whole(self, motion: PartMotion, errors: Sequence[ToolError]) -> ContourError:
        """RMS by length, the largest of the rest."""
        length = [cut.turn.length for cut in motion.cuts]

        def largest(name: str, most: Callable[[Array], float] = np.max) -> float:
            values = np.array([getattr(error, name) for error in errors])
            return float(most(values)) if np.isfinite(values).any() else np.nan

        rms = np.array([error.rms for error in errors])
        return ContourError(
            rms=float(np.sqrt(np.average(rms**2, weights=length))),
            maxdev=largest("maxdev"),
            position=largest("position"),
            path_accuracy=largest("path_accuracy"),
            roundness=largest("roundness", np.nanmax),
            corner=largest("corner", np.nanmax),
            path=np.concatenate([error.path for error in errors]),
        )

    def contours(self, motion: PartMotion) -> Sequence[Timed]:
        return timed(motion)

    def weights(self, motion: PartMotion) -> Array:
        """(N, M), of each correction: its contour, and what follows until the next pierces."""
        begun = np.ones((motion.n_samples, len(motion.cuts) + 1))
        begun[:, -1] = 0.0
        for i, cut in enumerate(motion.cuts[1:], start=1):
            before = max(leg.end for leg in motion.legs if leg.end <= cut.start)
            width = max(cut.start - before, SHORTEST_BLEND)
            x = np.clip((motion.time - cut.start) / width + 1.0, 0.0, 1.0)
            begun[:, i] = 0.5 - 0.5 * np.cos(np.pi * x)
        return begun[:, :-1] - begun[:, 1:]

    def notes(self, motion: PartMotion) -> Iterator[Note]:
        return plan_notes(self.plan)

    def entries(
        self, motion: PartMotion, contours: Sequence[Sequence[Row]], ends: Sequence[Ended]
    ) -> Row:
        found = [
            {
                "name": cut.name,
                "kind": cut.kind,
                "length": cut.turn.length,
                "asked_speed": cut.asked_speed,
                "reached_speed": cut.reached_speed,
                "start": cut.start,
                "seconds": cut.timing.duration,
                "iterations": [rows[i] for rows in contours],
                "kerf": [
                    _edges(k, errors[i], motion.places[i], self.cutting.beam) for k, errors in ends
                ],
            }
            for i, cut in enumerate(motion.cuts)
        ]
        return {"seconds": motion.motion_end - motion.rest_before, "contours": found}


def timed(motion: PartMotion) -> Sequence[Timed]:
    """Contours of a part in their order."""
    return [Timed(cut.name, *cut.contour_time) for cut in motion.cuts]


def reference(setup: Setup, controller: Statics, motion: PartMotion) -> Array:
    """(N, 6) [rad], of the motion, shifted against the anticipated deflection."""
    robot, limits = setup.cell.robot, setup.cell.limits
    try:
        phi = joint_reference(motion, robot, limits)
        use = np.abs(np.gradient(phi, LOG_PERIOD, axis=0)) / np.array(limits.speed)
        if use.max() > 1.0 + EXCESS:
            sample, axis = divmod(int(use.argmax()), use.shape[1])
            raise JointSpeedError(f"axis {axis + 1} would be too fast at {_where(motion, sample)}")
        shift = smoothed(anticipated_shift(controller, phi, LOG_PERIOD))
        return joint_reference(motion, robot, limits, start=phi[0], shift=shift)
    except (UnreachableError, JointRangeError) as error:
        raise out_of_reach(error, _where(motion, error.index), robot) from error


def _where(motion: PartMotion, sample: int) -> str:
    in_plane = motion.plane.from_base(motion.position[sample])[:2]
    return place(in_plane + np.array(motion.middle))


def plan_notes(plan: Plan) -> Iterator[Note]:
    """Notes of a plan: what the drawing left out, and bends and ramps that are slower."""
    for text in plan.part.notes:
        yield Note(cause=Cause.DRAWING, text=text)
    asked, limit = plan.cutting.speed, plan.cutting.limits.acceleration
    if slow := [cut for cut in plan.cuts if cut.lowest_allowed < REACHED * asked]:
        lowest = 1e3 * min(cut.lowest_allowed for cut in slow)
        where = f"bends of {len(slow)} of {len(plan.cuts)} contours"
        text = f"the speed is lowered from {1e3 * asked:.4g} mm/s to {lowest:.4g} mm/s in {where}"
        yield Note(cause=Cause.SPEED, text=f"{text}: {limit:g} m/s^2 across the path")
    short = [cut for cut in plan.cuts if cut.reached_speed < REACHED * cut.profile.allowed.max()]
    if short:
        reached = f"{1e3 * min(cut.reached_speed for cut in short):.4g} mm/s at least"
        which = named([cut.contour.name for cut in short])
        text = f"too short to reach their speed, {reached}: {which}"
        yield Note(cause=Cause.ACCELERATION, text=text)


def _edges(k: int, error: ToolError, place: ContourPlace, beam: float) -> Row:
    """Median and largest width of the kerf of a contour [m], of the ground truth."""
    width = kerf(place.curve, error.path, beam, closed=place.closed).width
    seen = width[np.isfinite(width)]  # a tight corner's normals may miss a path beside it
    median, widest = (np.median(seen), seen.max()) if len(seen) else (np.nan, np.nan)
    return {"k": k, "width_true": float(median), "widest_true": float(widest)}


def logged(iteration: Iteration) -> RecordedRun:
    """Log, ground truth and tracker of an iteration, all at the log rate."""
    log, seen = iteration.run.recording, iteration.run.tracker
    truth = log.truth.every(stride(rate_of(log.truth.time), 1.0 / LOG_PERIOD))
    every = stride(rate_of(seen.time), 1.0 / LOG_PERIOD)
    tracker = TrackerSamples(
        time=seen.time[::every], position=seen.position[::every], valid=seen.valid[::every]
    )
    return RecordedRun(k=iteration.k, recording=replace(log, truth=truth), tracker=tracker)
