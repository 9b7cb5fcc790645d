"""First run of a robot that has a twin: its correction, and the friction that the run shows.

    torque residual_i = (dF_i / d log f_i) log f_i        log f_i ~ N(0, 0.15^2)

One factor for each axis covers temperature and wear alike: what it leaves of the torque says when
the robot should be commissioned again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..laser.experiment import Experiment, Pass
from ..laser.measures import Measure, MotorAngles
from ..laser.specification import Cut
from ..laser.tool_measure import Source, ToolPath
from ..notes import Cause, Note
from . import twin as library
from .prediction import Corrected
from .recordings import MeasuredCut, measured_from
from .twin import Twin

_PRIOR = 0.15
"""Standard deviation of log(factor). ESTIMATE."""
_STEP = 0.05
_TURNS = 2
_LARGEST_DRIFT = 0.3
_LARGEST_GROWTH = 4.0
"""Torque residual over that at commissioning, from which on a robot is commissioned again."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Refreshed:
    """A twin after production runs."""

    twin: Twin
    growth: Array
    """(6,), torque residual over that of the commissioning cuts."""

    @property
    def advice(self) -> str | None:
        """Reason to commission the robot again; None where there is none."""
        drift = np.abs(np.log(self.twin.friction))
        axis = int(drift.argmax())
        if drift[axis] > np.log1p(_LARGEST_DRIFT):
            factor = self.twin.friction[axis]
            return f"friction of axis {axis + 1} is {factor:.2f} times that at commissioning"
        axis = int(self.growth.argmax())
        if self.growth[axis] > _LARGEST_GROWTH:
            growth = self.growth[axis]
            return f"torque of axis {axis + 1} is no longer explained: {growth:.1f} times"
        return None


def refreshed(twin: Twin, runs: Sequence[MeasuredCut], payload: float | None = None) -> Refreshed:
    """The twin with the friction that production runs show, with a tool of that mass [kg]; that of
    the robot's file if None."""
    design = twin.design_with(payload)
    least = 1e-3 * design.model.drives.torque_limit
    noise = np.maximum(3.0 * twin.torque_residual, least)
    for _ in range(_TURNS):
        information, gradient = np.full(6, _PRIOR**-2.0), -np.log(twin.friction) * _PRIOR**-2.0
        for run in runs:
            more = replace(twin.individual, friction=twin.friction * np.exp(_STEP))
            base, other = design.run([twin.individual, more], run.reference, run.correction)
            slope = (other.motor_torque - base.motor_torque)[run.moving] / _STEP
            residual = (run.motor_torque - base.motor_torque)[run.moving]
            information = information + np.sum(slope**2, axis=0) / noise**2
            gradient = gradient + np.sum(slope * residual, axis=0) / noise**2
        twin = replace(twin, friction=twin.friction * np.exp(gradient / information))
    left = []
    for run in runs:
        simulated = design.run([twin.individual], run.reference, run.correction)[0]
        residual = (run.motor_torque - simulated.motor_torque)[run.moving]
        left.append(np.mean(residual**2, axis=0))
    rms = np.sqrt(np.mean(left, axis=0))
    return Refreshed(twin=twin, growth=rms / np.maximum(twin.torque_residual, least))


LONG = 0.05
"""Change of a motor angle along a cut [rad], up to which an estimate of one place sees a run of the
twin as it sees the robot's: springs that are effective at one place act differently at another."""


@dataclass(frozen=True, eq=False)
class FirstCut:
    """A twin and its correction for a cut."""

    twin: Twin
    found: Corrected

    @property
    def start(self) -> Array | None:
        """(N, 6) [rad], arm side, correction of the first run; None where the twin is not used."""
        return self.found.correction if self.found.trusted else None

    def around(self, measure: Measure, experiment: Experiment) -> Measure:
        """The measure that learning goes on with: what its sensor sees of the twin is learned.

        A model's run is compared by an estimate of one place. Along a long path that does not hold:
        the programmed path stays the target, and estimate and law follow the pose.
        """
        reference = experiment.loaded.reference
        if self.found.trusted and isinstance(measure, MotorAngles):
            return replace(measure, target=self.found.motor_path)
        if not self.found.trusted or not isinstance(measure, ToolPath):
            return measure
        if np.ptp(reference, axis=0).max() > LONG and measure.source is Source.ESTIMATE:
            return measure
        run = self.twin.run(experiment.cut, reference, self.found.correction)
        return replace(measure, target=run)

    @property
    def predicted(self) -> dict[str, Any]:
        """The predicted error of the first run, as summary.json has it."""
        found, expected = self.found, self.found.prediction
        return {
            "arm_rms": expected.expected,
            "interval": [expected.low, expected.high] if expected.calibrated else None,
            "uncorrected": expected.uncorrected,
            "trusted": found.trusted,
            "reason": found.reason,
        }

    @property
    def notes(self) -> list[Note]:
        """A note where the twin is not used."""
        if self.found.reason is None:
            return []
        why = f"the twin is not trusted here: {self.found.reason}"
        return [Note(cause=Cause.TWIN, text=f"{why}; the first run is not corrected")]

    def shown_by(self, first: Pass, payload: float | None) -> tuple[dict[str, Any], list[Note]]:
        """Entry `twin` of summary.json: the friction that the first run shows; and a note where the
        twin should be made again. payload: as of `refreshed`."""
        run = measured_from(first.recording, "first run")  # friction shows without a tracker
        after = refreshed(self.twin, [run], payload)
        friction, advice = after.twin.friction, after.advice
        text = f"commission the robot again: {advice}"
        notes = [] if advice is None else [Note(cause=Cause.TWIN, text=text)]
        return {"friction": friction, "torque_growth": after.growth, "advice": advice}, notes


def first_cut(folder: Path, experiment: Experiment) -> FirstCut:
    """Twin of a folder and its correction for the run of an experiment. Raises ValueError for a
    folder without a twin, or one of another robot."""
    twin, cut = library.stored_twin(folder), experiment.cut
    one = isinstance(cut, Cut)
    return FirstCut(twin, library.learned(twin, cut) if one else twin.correction_of(experiment))
