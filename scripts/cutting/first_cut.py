"""The first cut of a robot that has a twin: its correction, and what its run says of the twin."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.arrays import Array
from armside.sim.laser.experiment import Experiment
from armside.sim.laser.measures import Measure, MotorAngles
from armside.sim.laser.plant import Pass
from armside.sim.laser.tool_measure import Source, ToolPath
from armside.sim.notes import Cause, Note
from armside.sim.twin import library
from armside.sim.twin.correction import Corrected
from armside.sim.twin.drift import Refreshed, refreshed
from armside.sim.twin.measured import measured_from
from armside.sim.twin.twin import Twin

from .options import LaserCfg

if TYPE_CHECKING:  # its package needs the extra of drawings
    from armside.sim.part_run.experiment import PartExperiment

LONG = 0.05
"""Change of a motor angle along a cut [rad], up to which an estimate of one place sees a run of the
twin as it sees the robot's: springs that are effective at one place act differently at another."""


@dataclass(frozen=True, eq=False)
class ByTwin:
    """A twin and its correction for a cut."""

    twin: Twin
    found: Corrected

    @property
    def start(self) -> Array | None:
        """(N, 6) [rad], arm side, correction of the first run; None where it is not trusted."""
        return self.found.correction if self.found.trusted else None

    def around(self, measure: Measure, experiment: "Experiment | PartExperiment") -> Measure:
        """The measure that learning goes on with: what its sensor sees of the twin is learned.

        A model's run is compared by an estimate of one place. Along a long way that does not hold:
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
            run = self.twin.run(experiment.setup, reference, self.found.correction)
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


def corrected(folder: Path, experiment: Experiment) -> ByTwin:
    """Twin of a folder and its correction.

    Raises ValueError for a folder without a twin, or one of another robot.
    """
    twin = library.stored_twin(folder)
    return ByTwin(twin, library.learned(twin, experiment.cut))


def corrected_part(folder: Path, experiment: "PartExperiment") -> ByTwin:
    """As `corrected`, along a whole part."""
    twin = library.stored_twin(folder)
    loaded = experiment.loaded
    found = twin.correction_along(experiment.setup, experiment.motion, loaded.reference)
    return ByTwin(twin, found)


def outcome(by_twin: ByTwin, first: Pass, cfg: LaserCfg) -> tuple[dict[str, Any], list[Note]]:
    """Entries of summary.json: the predicted error, and the friction that the run shows; notes."""
    run = measured_from(first.recording, None, "first run")  # friction shows without a tracker
    after = refreshed(by_twin.twin, [run], cfg.payload)
    entries = {
        "predicted": by_twin.predicted,
        "twin": {
            "folder": cfg.twin,
            "friction": after.twin.friction,
            "torque_growth": after.growth,
            "advice": after.advice,
        },
    }
    return entries, notes(by_twin.found, after)


def trust(found: Corrected) -> list[Note]:
    """A note where the twin was not trusted."""
    if found.reason is None:
        return []
    text = f"the twin is not trusted here: {found.reason}; the first run is not corrected"
    return [Note(cause=Cause.TWIN, text=text)]


def notes(found: Corrected, after: Refreshed) -> list[Note]:
    """Notes of a first cut: a twin that was not trusted, or that should be made again."""
    made = trust(found)
    if after.advice is not None:
        made.append(Note(cause=Cause.TWIN, text=f"commission the robot again: {after.advice}"))
    return made


def line(predicted: dict[str, Any], rows: list[dict[str, Any]]) -> str:
    """What was predicted of the first run and what was measured, in one line.

    The interval is that of a run with the correction: of one that is not trusted it is not printed,
    nor is one that was not fitted to twins by that sensor and of so few cuts.
    """
    first, uncorrected = rows[0]["arm_rms"], f"{1e6 * predicted['uncorrected']:.0f} um"
    seen = "not measured" if first is None else f"{1e6 * first:.1f} um"
    if not predicted["trusted"]:
        return (
            f"First cut without correction: {seen}, {uncorrected} by the twin, which is not trusted"
        )
    said = (
        f"First cut by the twin: {seen}, {uncorrected} without correction; "
        f"predicted {1e6 * predicted['arm_rms']:.1f} um"
    )
    if predicted["interval"] is None:
        return f"{said}, of unknown accuracy for a twin of so few cuts"
    low, high = (1e6 * value for value in predicted["interval"])
    return f"{said}, {low:.1f} to {high:.1f} um (90 %)"
