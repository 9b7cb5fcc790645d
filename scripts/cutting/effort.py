"""Time and memory that runs of a cut take, estimated from its contour and speed."""

from ..shell.effort import Effort

LEADS = 1.5
"""Length of the programmed path over that of the contour, rounded up."""
REST = 2.0
"""[s], of each run beside the cut: rest before and after, acceleration."""
PLANNING = Effort(0.2, 20e6)
"""For each second of motion, before the first run: reference, statics and physics of one run."""
RUN = Effort(0.1, 2e6)
"""For each second of a run: physics, and the signals that are kept."""
ESTIMATED = Effort(3.0, 4e6)
"""For each second of a run, where the tool is estimated besides."""


def effort(length: float, speed: float, runs: int, *, estimated: bool = False) -> Effort:
    """Estimate for runs along a contour. length: [m]. speed: [m/s]."""
    seconds = LEADS * length / speed + REST
    each = RUN + ESTIMATED if estimated else RUN
    return (PLANNING + each * runs) * seconds
