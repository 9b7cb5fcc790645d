"""First runs by a twin of a robot individual, beside those without correction."""

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from armside.arrays import Array
from armside.sim.evaluation.check import Check
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare, true_tool_error
from armside.sim.laser.results import pass_notes
from armside.sim.laser.specification import Cut
from armside.sim.motion.tool_motion import motion_notes
from armside.sim.notes import Tally
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import plan, recorded
from armside.sim.twin.prediction import Corrected
from armside.sim.twin.recordings import MeasuredCut
from armside.sim.twin.twin import Twin

from ._tasks import JUDGED_SEED


def commissioning_cuts(robot: Drawn, count: int, imu: ImuCfg | None = None) -> list[MeasuredCut]:
    """Recorded cuts of the plan, by an individual that may carry an IMU."""
    return [
        recorded(replace(cut, individual=robot, imu=imu), f"cut-{i + 1}", i)
        for i, cut in enumerate(plan(count))
    ]


def hidden_hinges(twin: Twin, robot: Drawn) -> int:
    """Number of hinges that an individual has and its twin does not know."""
    return len(robot.of(twin.design.nominal or twin.design.model).hidden)


def tool_rms(cut: Cut, robot: Drawn, correction: Array | None, tally: Tally) -> float:
    """True tool RMS [m] of a run, whose notes are counted."""
    experiment = prepare(replace(cut, individual=robot), seed=JUDGED_SEED)
    zero = np.zeros_like(experiment.loaded.reference)
    run = experiment.plant.run(zero if correction is None else correction)
    of_motion = motion_notes(experiment.motion, experiment.cut.limits)
    tally.add((*of_motion, *pass_notes(experiment, run)))
    return true_tool_error(experiment.motion, run).rms


def left_alone(cut: Cut, robot: Drawn, tally: Tally) -> float:
    """True tool RMS [m] of a run without correction."""
    return tool_rms(cut, robot, None, tally)


def first_runs(
    twin: Twin, robot: Drawn, cuts: Sequence[Cut], tally: Tally
) -> tuple[Array, list[Corrected], list[float]]:
    """True tool RMS (n,) [m] of first runs, their corrections, and the seconds these took."""
    errors, corrections, seconds = list[float](), list[Corrected](), list[float]()
    for cut in cuts:
        began = time.perf_counter()
        corrections.append(twin.correction(cut))
        seconds.append(time.perf_counter() - began)
        errors.append(tool_rms(cut, robot, corrections[-1].correction, tally))
    return np.array(errors), corrections, seconds


def in_its_interval(errors: Array, corrections: Sequence[Corrected]) -> np.ndarray:
    """(m,) bool: errors (n,) [m] of first runs were in the interval, of the m that were corrected.

    Of the others no interval is printed.
    """
    ends = [(c.prediction.low, c.prediction.high) for c in corrections]
    low, high = np.reshape(ends, (-1, 2)).T
    inside = (low <= errors) & (errors <= high)
    return inside[[c.trusted for c in corrections]]


def in_the_interval(which: str, inside: np.ndarray) -> Check:
    """Verdict on errors (n,) bool, inside the predicted interval."""
    what, coverage = f"{which}errors inside the interval of 90 %", float(inside.mean())
    return Check("", what, "", coverage, low=0.85, high=0.95)
