"""Results of a cutting experiment: its notes, and the entries of its `summary.json`."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from operator import attrgetter
from typing import Any, Literal

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures

from ..evaluation.kerf import kerf
from ..evaluation.tool_error import ToolError, path_measures
from ..instruments.laser_tracker import beam
from ..motion.tool_motion import ToolMotion
from ..notes import GROWTH, Cause, Note, together
from ..robot.linkage import checked_loop_error
from ..robot.recording import every_drive_saturates, saturation
from .experiment import Experiment, Iteration, Pass
from .specification import Row

NAMED = 3
"""Contours that a note names at most."""


def notes(experiment: Experiment, iterations: Sequence[Iteration]) -> list[Note]:
    """Notes of an experiment and of its iterations, each once."""
    of_runs = [note for it in iterations for note in iteration_notes(experiment, it)]
    return all_notes(experiment, of_runs, iterations[0], iterations[-1])


def all_notes(
    experiment: Experiment, of_runs: Sequence[Note], first: Iteration, last: Iteration
) -> list[Note]:
    """Each note once: of the plan, of the runs, and of contours that learning made worse."""
    cut, motion = experiment.cut, experiment.motion
    names = [contour.name for contour in cut.contours(motion)]
    after = () if last.diverged else last.contours
    return together([*cut.notes(motion), *of_runs, *_growth(names, first.contours, after)])


def iteration_notes(experiment: Experiment, iteration: Iteration) -> list[Note]:
    """Notes of one iteration."""
    found = (*pass_notes(experiment, iteration.run), *iteration.notes)
    return [note.at(iteration.k) for note in found]


def pass_notes(experiment: Experiment, run: Pass) -> Iterator[Note]:
    """Notes of one run."""
    yield from saturation(run.recording)
    yield from beam(run.tracker)
    if run.imu is None or experiment.cut.imu is None:
        return
    from ..estimation.imu_health import ImuError, repaired

    try:
        samples = repaired(run.imu, experiment.cut.imu)
    except ImuError as error:
        yield Note(cause=Cause.IMU, text=f"{error}; they are not used")
        return
    if np.isnan(samples.acceleration).any():
        yield Note(cause=Cause.IMU, text="lost or clipped samples of the IMU are bridged")


def named(names: Sequence[str]) -> str:
    """The first of several names, and how many more there are."""
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def _growth(
    names: Sequence[str], first: Sequence[ToolError], last: Sequence[ToolError]
) -> Iterator[Note]:
    """The tool against its first run: what is learned from may be blind to it."""
    worse = [names[i] for i, after in enumerate(last) if after.rms > GROWTH * first[i].rms]
    rms = [f"{1e6 * each[0].rms:.4g}" for each in (first, last) if each]
    if len(names) > 1 and worse:
        text = f"learning made {len(worse)} of {len(names)} contours worse: {named(worse)}"
        yield Note(cause=Cause.TOOL, text=text)
    elif worse:
        text = f"learning made the tool worse: RMS {' to '.join(rms)} um"
        yield Note(cause=Cause.TOOL, text=text)


Status = Literal["done", "worse", "diverged", "saturated"]
"""End of a run. Worse: it learned from the tool, whose error grew as the tracker sees it.
Saturated: at the end an axis ran into its hard stop, or each drive that was to move was at its
torque limit."""


def results(
    experiment: Experiment, iterations: Iterable[Iteration], *, of_tool: bool = False
) -> dict[str, Any]:
    """Status, limits and measures of a run, as `summary.json` has them.

    iterations: gone through once, so that those of a long part need not be stored.
    of_tool: as of `status`.

    Raises RuntimeError for a closed chain that did not stay closed.
    """
    cut, motion = experiment.cut, experiment.motion
    rows, contours = list[Row](), list[list[Row]]()
    ends, notes, open_by = list[Iteration](), list[Note](), [0.0]
    limits = [(None, hit) for hit in motion.limits_hit]
    beam_lost = list[bool]()
    for it in iterations:
        ends = [*ends[:1], it]
        rows.append(iteration_row(it))
        contours.append(_contour_rows(it))
        notes += iteration_notes(experiment, it)
        limits += [(it.k, hit) for hit in it.run.recording.limits_hit]
        beam_lost.append(not bool(it.run.tracker.valid.all()))
        if not it.diverged:
            open_by.append(_loop_error(experiment, it.run))
    for row in rows:
        for name in ("motor_inf", "motor_two", "arm_rms", "arm_maxdev"):
            row[f"{name}_normalised"] = _normalised(row[name], rows[0][name])
    return {
        "status": status(ends, of_tool=of_tool),
        "limits_hit": [
            {"k": k, "limit": name, "axis": axis, "time": time} for k, (name, axis, time) in limits
        ],
        "loop_error": max(open_by),
        "notes": all_notes(experiment, notes, ends[0], ends[-1]),
        "beam_lost": beam_lost,
        "iterations": rows,
        **cut.entries(motion, contours, [(it.k, it.contours_true) for it in ends]),
    }


def status(iterations: Sequence[Iteration], *, of_tool: bool) -> Status:
    """End of a run.

    of_tool: it learned from the tool. Of one that learned from its motors, `notes` say that the
    tool got worse.
    """
    first, last = iterations[0], iterations[-1]
    if last.diverged:
        return "diverged"
    recording = last.run.recording
    stopped = any(name == "joint" for name, *_ in recording.limits_hit)
    if stopped or every_drive_saturates(recording):
        return "saturated"
    return "worse" if of_tool and last.tool.rms > GROWTH * first.tool.rms else "done"


def iteration_row(iteration: Iteration) -> Row:
    """Measures of one iteration: motor errors (n,) [rad] of the shaft, tool errors [m], and those
    of `MotionError`."""
    return {
        "k": iteration.k,
        "motor_inf": measures.inf_norm(iteration.motor_error),
        "motor_two": measures.two_norm(iteration.motor_error),
        **_measures(iteration.tool, ""),
        **_measures(iteration.tool_true, "_true"),
        **vars(iteration.motion_error),
    }


def _contour_rows(iteration: Iteration) -> list[Row]:
    each = zip(iteration.contours, iteration.contours_true, iteration.converged, strict=True)
    return [
        {"k": iteration.k, **_measures(seen, ""), **_measures(true, "_true"), "converged": held}
        for seen, true, held in each
    ]


def _measures(error: ToolError, suffix: str) -> Row:
    names = (field.name for field in fields(error) if field.name != "path")
    return {f"arm_{name}{suffix}": getattr(error, name) for name in names}


def _normalised(measure: Any, first: Any) -> Any:
    """NaN where the first run was not measured: the tracker had lost its beam."""
    return measures.normalise(measure, first) if np.isfinite(first).all() else measure * np.nan


def _loop_error(experiment: Experiment, run: Pass) -> float:
    loaded = experiment.loaded
    return checked_loop_error(loaded.model.mj, run.recording.truth.qpos[:: loaded.ratio])


def quality(
    experiment: Experiment[ToolMotion],
    iterations: list[Iteration],
    repeated: Sequence[Pass],
    beam: float,
) -> dict[str, Any]:
    """The edge that a beam of that diameter [mm] leaves, and measures after ISO 9283 [m]."""
    motion, beam = experiment.motion, beam * 1e-3
    cuts = [kerf(motion.curve, it.tool.path, beam) for it in iterations]
    true_cuts = [kerf(motion.curve, it.tool_true.path, beam) for it in iterations]
    iso: dict[str, Any] = {"repetitions": len(repeated)}
    for suffix, samples in (("", attrgetter("tracked")), ("_true", _true)):
        each = [path_measures(motion, [samples(it.run)]) for it in iterations]
        iso[f"path_accuracy{suffix}"] = [m.accuracy for m in each]
        iso[f"path_accuracy_in_plane{suffix}"] = [m.accuracy_in_plane for m in each]
        if repeated:
            of_all = path_measures(motion, [samples(run) for run in repeated])
            iso[f"path_accuracy_of_repetitions{suffix}"] = of_all.accuracy
            iso[f"path_repeatability{suffix}"] = of_all.repeatability
            iso[f"path_repeatability_in_plane{suffix}"] = of_all.repeatability_in_plane
    edges = {
        "beam": beam,
        "hole_roundness": [cut.roundness for cut in cuts],
        "hole_roundness_true": [cut.roundness for cut in true_cuts],
        "widest_true": [float(cut.width.max()) for cut in true_cuts],
    }
    return {"kerf": edges, "iso": iso}


def _true(run: Pass) -> tuple[Array, Array]:
    return run.recording.truth.time, run.recording.truth.tool_position
