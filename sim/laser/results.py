"""Results of a cutting experiment: the entries of its `summary.json`."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures

from ..evaluation.kerf import kerf
from ..evaluation.tool_error import path_measures
from ..robot.linkage import checked_loop_error
from .experiment import Experiment, Iteration, prepare
from .learning import iterate
from .measures import Measure, MotorAngles
from .notes import GROWTH, notes
from .plant import Pass
from .specification import Cut
from .tool_measure import ToolPath

Status = Literal["done", "worse", "diverged"]
"""End of a run. Worse: it learned from the tool, whose error grew as the tracker sees it."""


def run(
    cut: Cut, *, measure: Measure = MotorAngles(), iterations: int = 5, seed: int = 0
) -> dict[str, Any]:
    """Learn a cut and return its `results`."""
    experiment = prepare(cut, seed=seed)
    found = iterate(experiment, measure.prepare(experiment), iterations)
    return results(experiment, list(found), of_tool=isinstance(measure, ToolPath))


def status(iterations: Sequence[Iteration], *, of_tool: bool) -> Status:
    """End of a run.

    of_tool: it learned from the tool. Of one that learned from its motors, `notes` say that the
    tool got worse.
    """
    first, last = iterations[0], iterations[-1]
    if last.diverged:
        return "diverged"
    return "worse" if of_tool and last.tool.rms > GROWTH * first.tool.rms else "done"


def results(
    experiment: Experiment, iterations: list[Iteration], *, of_tool: bool = False
) -> dict[str, Any]:
    """Status, limits and measures of a run, as `summary.json` has them.

    of_tool: as of `status`.

    Raises RuntimeError for a closed chain that did not stay closed.
    """
    rows = [iteration_row(it) for it in iterations]
    for row in rows:
        for name in ("motor_inf", "motor_two", "arm_rms", "arm_maxdev"):
            row[f"{name}_normalised"] = _normalised(row[name], rows[0][name])
    motion = experiment.motion
    return {
        "status": status(iterations, of_tool=of_tool),
        "limits_hit": [
            {"k": k, "limit": name, "axis": axis, "time": time}
            for k, hits in (
                (None, motion.limits_hit),
                *((it.k, it.run.recording.limits_hit) for it in iterations),
            )
            for name, axis, time in hits
        ],
        "loop_error": _loop_error(experiment, iterations),
        "reached_speed": motion.reached_speed,
        "notes": notes(experiment, iterations),
        "beam_lost": [not bool(it.run.tracker.valid.all()) for it in iterations],
        "iterations": rows,
    }


def _normalised(measure: Any, first: Any) -> Any:
    """NaN where the first run was not measured: the tracker had lost its beam."""
    return measures.normalise(measure, first) if np.isfinite(first).all() else measure * np.nan


def _loop_error(experiment: Experiment, iterations: list[Iteration]) -> float:
    """Widest opening of a closed chain over all runs but one that diverged [m]; 0 for none."""
    mj, stride = experiment.loaded.model.mj, experiment.loaded.ratio
    states = (it.run.recording.truth.qpos[::stride] for it in iterations if not it.diverged)
    return max((checked_loop_error(mj, qpos) for qpos in states), default=0.0)


def quality(
    experiment: Experiment, iterations: list[Iteration], repeated: Sequence[Pass], beam: float
) -> dict[str, Any]:
    """The edge that a beam of that diameter [mm] leaves, and measures after ISO 9283 [m].

    repeated: runs with the last correction.
    """
    motion, curve = experiment.motion, experiment.cut.curve
    true_cuts = [kerf(curve, it.tool_true.path, beam * 1e-3) for it in iterations]
    iso: dict[str, Any] = {"repetitions": len(repeated)}
    for suffix, samples in (("", _tracked), ("_true", _true)):
        each = [path_measures(motion, [samples(run)]) for run in (it.run for it in iterations)]
        iso[f"path_accuracy{suffix}"] = [m.accuracy for m in each]
        iso[f"path_accuracy_in_plane{suffix}"] = [m.accuracy_in_plane for m in each]
        if repeated:
            together = path_measures(motion, [samples(run) for run in repeated])
            iso[f"path_accuracy_of_repetitions{suffix}"] = together.accuracy
            iso[f"path_repeatability{suffix}"] = together.repeatability
            iso[f"path_repeatability_in_plane{suffix}"] = together.repeatability_in_plane
    return {
        "kerf": {
            "beam": beam * 1e-3,
            "hole_roundness": [
                kerf(curve, it.tool.path, beam * 1e-3).roundness for it in iterations
            ],
            "hole_roundness_true": [cut.roundness for cut in true_cuts],
            "widest_true": [float(cut.width.max()) for cut in true_cuts],
        },
        "iso": iso,
    }


def _tracked(run: Pass) -> tuple[Array, Array]:
    return run.tracker.time, run.tracker.position


def _true(run: Pass) -> tuple[Array, Array]:
    return run.recording.truth.time, run.recording.truth.tool_position


def iteration_row(iteration: Iteration) -> dict[str, Any]:
    """Measures of one iteration: motor errors (n,) [rad] of the shaft, tool errors [m]."""
    return {
        "k": iteration.k,
        "motor_inf": measures.inf_norm(iteration.motor_error),
        "motor_two": measures.two_norm(iteration.motor_error),
        "arm_rms": iteration.tool.rms,
        "arm_maxdev": iteration.tool.maxdev,
        "arm_rms_true": iteration.tool_true.rms,
        "arm_maxdev_true": iteration.tool_true.maxdev,
    }
