"""The first run of a robot that has a twin: its correction, and what the run shows of the twin."""

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
from .correction import Corrected
from .drift import refreshed
from .recordings import measured_from
from .twin import Twin

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
        if not self.found.trusted:
            return measure
        long = np.ptp(experiment.loaded.reference, axis=0).max() > LONG
        if long and isinstance(measure, ToolPath) and measure.source is Source.ESTIMATE:
            return measure
        if isinstance(measure, MotorAngles):
            return replace(measure, target=self.found.motor_path)
        if isinstance(measure, ToolPath):
            reference = experiment.loaded.reference
            run = self.twin.run(experiment.cut, reference, self.found.correction)
            return replace(measure, target=run)
        return measure

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
        twin should be made again.

        payload: mass of the tool in that run [kg]; that of the robot's file if None.
        """
        run = measured_from(first.recording, None, "first run")  # friction shows without a tracker
        after = refreshed(self.twin, [run], payload)
        text = f"commission the robot again: {after.advice}"
        notes = [] if after.advice is None else [Note(cause=Cause.TWIN, text=text)]
        entry = {
            "friction": after.twin.friction,
            "torque_growth": after.growth,
            "advice": after.advice,
        }
        return entry, notes


def first_cut(folder: Path, experiment: Experiment) -> FirstCut:
    """Twin of a folder and its correction for the run of an experiment.

    Raises ValueError for a folder without a twin, or one of another robot.
    """
    twin, cut = library.stored_twin(folder), experiment.cut
    if isinstance(cut, Cut):
        return FirstCut(twin, library.learned(twin, cut))
    return FirstCut(twin, twin.correction_of(experiment))
