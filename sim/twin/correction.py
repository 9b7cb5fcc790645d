"""Correction for the first run of a cut, with the error to expect and a guard."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from ..laser.experiment import Experiment
from ..robot.individual import Individual
from .learning import learn_in_twin
from .prediction import Evidence, FirstCutPrediction, errors, predicted
from .simulation import RobotDesign, motor_path


@dataclass(frozen=True, kw_only=True, eq=False)
class Corrected:
    """Correction for the first run of a cut."""

    correction: Array
    """(N, 6) [rad], arm side; zero where the twin is not trusted."""
    learned: Array = field(repr=False)
    """(N, 6) [rad], what the twin learned, trusted or not."""
    motor_path: Array = field(repr=False)
    """(N, 6) [rad], arm side: the twin's motors with the correction in use."""
    prediction: FirstCutPrediction
    reason: str | None
    """Why the twin's correction is not used; None where it is."""

    @property
    def trusted(self) -> bool:
        """The twin's correction is used."""
        return self.reason is None


LARGEST_FRACTION = 0.3
"""Upper end of the predicted error over that without correction, from which on none is used."""


def correct(
    design: RobotDesign,
    individual: Individual,
    around: Sequence[Individual],
    experiment: Experiment,
    evidence: Evidence,
) -> Corrected:
    """Learn the motion of an experiment inside a twin and predict what its correction leaves.

    Args:
        around: individuals that commissioning cannot tell from the twin.
        evidence: what the twin was identified from.
    """
    learned = learn_in_twin(design, individual, experiment)
    spread = errors(design, around, experiment, learned.correction)
    prediction = predicted(float(learned.rms[0]), float(learned.rms.min()), spread, evidence)
    reason = _objection(prediction)
    used = learned.correction if reason is None else np.zeros_like(learned.correction)
    motors = motor_path(design.run([individual], experiment.loaded.reference, used)[0])
    return Corrected(
        correction=used,
        learned=learned.correction,
        motor_path=motors,
        prediction=prediction,
        reason=reason,
    )


def _objection(prediction: FirstCutPrediction) -> str | None:
    if not np.isfinite(prediction.high):
        return "the twin becomes unstable with its correction"
    fraction = prediction.high / prediction.uncorrected
    if fraction > LARGEST_FRACTION:
        return f"up to {100 * fraction:.0f} % of the error would be left"
    return None
