"""Tool error of a twin's run, as a tracker would see it."""

import numpy as np

from ..evaluation.contour_error import contour_errors
from ..evaluation.tool_error import tool_error
from ..part.carried import Motion
from ..part.motion import PartMotion
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD


def twin_error(motion: Motion, run: Recording) -> float:
    """RMS tool error [m] of a run of a twin: of a cut at 1 kHz, of a part over all its contours.

    Infinite where the run became unstable.
    """
    truth = run.truth
    if not np.isfinite(truth.tool_position).all():
        return float("inf")
    period = LOG_PERIOD if isinstance(motion, PartMotion) else 1e-3
    every = slice(None, None, round(period / float(truth.time[1])))
    seen = truth.time[every], truth.tool_position[every]
    if not isinstance(motion, PartMotion):
        return tool_error(motion, *seen).rms
    length = [cut.turn.length for cut in motion.cuts]
    squares = [error.rms**2 for error in contour_errors(motion, *seen)]
    return float(np.sqrt(np.average(squares, weights=length)))
