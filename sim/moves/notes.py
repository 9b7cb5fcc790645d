"""Notes of a planned program: moves that are slower than programmed, by what limits them."""

from collections.abc import Iterator

from ..notes import Cause, Note
from .planner import JointMotion


def slower_moves(motion: JointMotion) -> Iterator[Note]:
    """A note for each limit, with the instructions that it slows down, counted from 1."""
    limits = dict.fromkeys(report.limited_by for report in motion.reports if report.limited_by)
    for limit in limits:
        moves = [str(r.instruction + 1) for r in motion.reports if r.limited_by == limit]
        slow = f"instructions {', '.join(moves)} are slower than programmed, at least in part"
        yield Note(cause=Cause.SPEED, text=f"{slow}: {limit}")
