"""Results of a learned part: the entries of its `summary.json`."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.ilc.measures import norms as measures

from ..evaluation.contour_error import ContourError
from ..evaluation.kerf import kerf
from ..laser.notes import GROWTH
from ..part.motion import ContourPlace, CutLeg
from .experiment import PartExperiment
from .learning import PartIteration

Row = dict[str, Any]
MEASURES = ("rms", "maxdev", "position", "path_accuracy", "roundness", "corner")
PARTIAL = ("roundness", "corner")
"""Measures that only some contours have."""


@dataclass(frozen=True, kw_only=True)
class Rows:
    """Measures of one iteration; small, whatever the length of the part."""

    k: int
    motor_inf: Any
    motor_two: Any
    """(6,) [rad] of the motor shaft."""
    contours: tuple[Row, ...]
    """Measures of each contour [m], by name."""
    limits_hit: tuple[tuple[str, int, float], ...]
    beam_lost: bool
    diverged: bool


def rows_of(iteration: PartIteration) -> Rows:
    """Measures of an iteration without its signals."""
    pairs = zip(iteration.contours, iteration.contours_true, strict=True)
    return Rows(
        k=iteration.k,
        motor_inf=measures.inf_norm(iteration.motor_error),
        motor_two=measures.two_norm(iteration.motor_error),
        contours=tuple(
            _measures(tracked, "") | _measures(true, "_true") | {"converged": kept}
            for (tracked, true), kept in zip(pairs, iteration.converged, strict=True)
        ),
        limits_hit=iteration.run.recording.limits_hit,
        beam_lost=not bool(iteration.run.tracker.valid.all()),
        diverged=iteration.diverged,
    )


def _measures(error: ContourError, suffix: str) -> Row:
    return {f"arm_{name}{suffix}": getattr(error, name) for name in MEASURES}


def results(
    experiment: PartExperiment, rows: Sequence[Rows], edges: Sequence[PartIteration] = ()
) -> dict[str, Any]:
    """Status, limits, and measures of each contour and of all together.

    edges: iterations whose kerf is computed.
    """
    motion, beam = experiment.motion, experiment.job.cutting.beam
    whole = [_whole(row, motion.cuts) for row in rows]
    for row in whole:
        for name in ("motor_inf", "motor_two", "arm_rms", "arm_maxdev"):
            row[f"{name}_normalised"] = _normalised(row[name], whole[0][name])
    return {
        "status": _status(rows, whole),
        "seconds": motion.motion_end - motion.rest_before,
        "limits_hit": [
            {"k": row.k, "limit": name, "axis": axis, "time": time}
            for row in rows
            for name, axis, time in row.limits_hit
        ],
        "beam_lost": [row.beam_lost for row in rows],
        "contours": [
            planned_contour(cut)
            | {"iterations": [{"k": r.k} | r.contours[i] for r in rows]}
            | {"kerf": [_edges(it, i, motion.places[i], beam) for it in edges]}
            for i, cut in enumerate(motion.cuts)
        ],
        "iterations": whole,
    }


def _edges(iteration: PartIteration, i: int, place: ContourPlace, beam: float) -> Row:
    """Median and largest width of the kerf of contour i [m], of the ground truth."""
    path = iteration.contours_true[i].path
    width = kerf(place.curve, path, beam, closed=place.closed).width
    seen = width[np.isfinite(width)]  # a tight corner's normals may miss a path beside it
    median, widest = (np.median(seen), seen.max()) if len(seen) else (np.nan, np.nan)
    return {"k": iteration.k, "width_true": float(median), "widest_true": float(widest)}


def planned_contour(cut: CutLeg) -> Row:
    """A contour as it is planned. SI units."""
    return {
        "name": cut.name,
        "kind": cut.kind,
        "length": cut.turn.length,
        "asked_speed": cut.asked_speed,
        "reached_speed": cut.reached_speed,
        "start": cut.start,
        "seconds": cut.timing.duration,
    }


def _whole(rows: Rows, cuts: Sequence[CutLeg]) -> Row:
    """All contours as one: RMS by length, the largest of the rest."""
    length = np.array([cut.turn.length for cut in cuts])
    found: Row = {"k": rows.k, "motor_inf": rows.motor_inf, "motor_two": rows.motor_two}
    for name in [f"arm_{measure}{s}" for s in ("", "_true") for measure in MEASURES]:
        values = np.array([row[name] for row in rows.contours])
        if any(one in name for one in PARTIAL):
            found[name] = float(np.nanmax(values)) if np.isfinite(values).any() else np.nan
        elif "rms" in name:
            found[name] = float(np.sqrt(np.average(values**2, weights=length)))
        else:
            found[name] = float(values.max())
    return found


def _normalised(measure: Any, first: Any) -> Any:
    """NaN where the first run was not measured: the tracker had lost its beam."""
    return measures.normalise(measure, first) if np.isfinite(first).all() else measure * np.nan


def _status(rows: Sequence[Rows], whole: Sequence[Row]) -> str:
    """done, diverged, or worse: the tool's error has grown, whatever was learned from."""
    if rows[-1].diverged:
        return "diverged"
    return "worse" if whole[-1]["arm_rms"] > GROWTH * whole[0]["arm_rms"] else "done"
