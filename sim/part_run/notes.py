"""Notes of a part: limits that lowered a speed, and contours that learning made worse."""

from collections.abc import Iterator, Sequence

from ..instruments.laser_tracker import beam
from ..laser.notes import GROWTH
from ..notes import Cause, Note, together
from ..part.plan import Plan
from ..robot.recording import saturation
from .learning import PartIteration
from .results import Rows

REACHED = 0.999
"""Fraction of the programmed speed that counts as reached."""
NAMED = 3
"""Contours that a note names at most."""


def plan_notes(plan: Plan) -> Iterator[Note]:
    """Notes of a plan: what the drawing left out, and bends and ramps that are slower."""
    for text in plan.part.notes:
        yield Note(cause=Cause.DRAWING, text=text)
    asked, limit = plan.cutting.speed, plan.cutting.limits.acceleration
    slow = [cut for cut in plan.cuts if cut.lowest_allowed < REACHED * asked]
    if slow:
        lowest = 1e3 * min(cut.lowest_allowed for cut in slow)
        where = f"bends of {len(slow)} of {len(plan.cuts)} contours"
        text = f"the speed is lowered from {1e3 * asked:.4g} mm/s to {lowest:.4g} mm/s in {where}"
        yield Note(cause=Cause.SPEED, text=f"{text}: {limit:g} m/s^2 across the path")
    short = [cut for cut in plan.cuts if cut.reached_speed < REACHED * cut.profile.allowed.max()]
    if short:
        reached = 1e3 * min(cut.reached_speed for cut in short)
        named = _named([cut.contour.name for cut in short])
        text = f"too short to reach their speed, {reached:.4g} mm/s at least: {named}"
        yield Note(cause=Cause.ACCELERATION, text=text)


def run_notes(iteration: PartIteration) -> list[Note]:
    """Notes of one run."""
    found = (*saturation(iteration.run.recording), *beam(iteration.run.tracker), *iteration.notes)
    return [note.at(iteration.k) for note in found]


def learning_notes(rows: Sequence[Rows], names: Sequence[str]) -> Iterator[Note]:
    """Contours whose error has grown, by the tracker."""
    first, last = rows[0].contours, rows[-1].contours
    worse = [
        name
        for name, before, after in zip(names, first, last, strict=True)
        if after["arm_rms"] > GROWTH * before["arm_rms"]
    ]
    if worse and not rows[-1].diverged:
        text = f"learning made {len(worse)} of {len(names)} contours worse: {_named(worse)}"
        yield Note(cause=Cause.TOOL, text=text)


def all_notes(plan: Plan, of_runs: Sequence[Note], rows: Sequence[Rows]) -> list[Note]:
    """Each note once."""
    names = [cut.contour.name for cut in plan.cuts]
    return together([*plan_notes(plan), *of_runs, *learning_notes(rows, names)])


def _named(names: Sequence[str]) -> str:
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
