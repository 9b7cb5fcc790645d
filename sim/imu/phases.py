"""Phases of a motion: synchronisation, programmed moves, and motors that stand still."""

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..motion.instructions import Program, Wait
from ..motion.planner import ProgramMotion
from ..robot.recording import Recording

SYNCHRONISATION_PAUSE = 1.0
"""Shortest wait between synchronisation and experiment [s]. Thesis 5.3.2 has a short pause."""
MOVING = 1e-4
"""A motor whose reference is slower than this is idle [rad/s]."""
SLOW_CIRCLE, FAST_CIRCLE, RECTANGLE = 0.5, 1.0, 5.0
"""Programmed speeds of the parts of the simultaneous motion [m/s]."""


def synchronised_at(program: Program, motion: ProgramMotion) -> float:
    """End of the first long wait after a move [s]: what comes before synchronises the clocks.

    0 for a program without one: all of it is the experiment.
    """
    moved = False
    for index, instruction in enumerate(program.instructions):
        if not isinstance(instruction, Wait):
            moved = True
        elif moved and instruction.seconds >= SYNCHRONISATION_PAUSE:
            later = [report.start for report in motion.reports if report.instruction > index]
            return min(later, default=0.0)
    return 0.0


def under_way(motion: ProgramMotion, time: Array, speed: float) -> NDArray[np.bool_]:
    """Instants (K,) [s] at which a move programmed at this path speed [m/s] is under way."""
    flag = np.zeros(len(time), dtype=bool)
    for report in motion.reports:
        if report.programmed.path == speed:
            flag |= (time >= report.start) & (time <= report.end)
    return flag


def idle_peaks(recording: Recording) -> Array:
    """Largest displacement of each motor while only others move, (n,) [rad], from the log.

    For every move of another motor, the largest departure of an idle motor from its angle at the
    start of that move; NaN for a motor that is never idle while another moves. Thesis 5.3.2.
    """
    period = float(recording.time[1] - recording.time[0])
    moving = np.abs(np.gradient(recording.reference, period, axis=0)) > MOVING
    peaks = np.full(recording.reference.shape[1], np.nan)
    for start, stop in _stretches(np.any(moving, axis=1)):
        for axis in np.flatnonzero(~moving[start:stop].any(axis=0)):
            angle = recording.motor_angle[start:stop, axis]
            peaks[axis] = np.fmax(peaks[axis], np.abs(angle - angle[0]).max())
    return peaks


def _stretches(flag: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(first, one past last) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flag, [False]))))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
