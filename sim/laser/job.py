"""A learning experiment as a job: everything it depends on, and the small arrays of its results."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures

from ..notes import Note
from .design import THESIS, Design
from .experiment import Experiment, Iteration, prepare
from .loop import iterate
from .measures import MotorAngles
from .results import iteration_row, notes
from .specification import Cut

RIPPLE_BAND = (5.0, 14.0)  # [Hz], around the resonances that learning leaves undamped
_PATH_STRIDE = 4  # tracker samples, 1 ms each
_PREPARATION = 1.0  # costs as much as a second of simulated motion


@dataclass(frozen=True, kw_only=True)
class LearningJob:
    """Learning a cut from motor angles."""

    cut: Cut = field(default_factory=Cut)
    design: Design = THESIS
    iterations: int = 5
    seed: int = 0
    repetition: int = 0
    """Repetition of the same experiment on the same robot: other noise only."""
    series: bool = True
    """Keep corrections, errors and tool paths, not only measures."""

    @property
    def cost(self) -> float:
        """Rough, relative: for the time left."""
        turn = self.cut.curve.length / self.cut.speed
        return (self.iterations + 1) * (1.2 * turn + 0.9) + _PREPARATION

    def run(self) -> dict[str, Array]:
        """Run it. Arrays have the iterations 0 .. K first.

        motor_inf, motor_two: (K, n) [motor rad]; fields of `MotionError`: (K,), of stops (K, S).
        arm_rms, arm_maxdev, arm_rms_true,
        arm_maxdev_true, ripple: (K,) [m]. reached_speed [m/s], gear (n,), diverged, motion_end
        [sample]. NaN where a diverged experiment had ended.
        With `series`: error, correction (K, N, n) [rad], path (K, M, 2) [m].
        """
        return self.noted()[0]

    def noted(self) -> tuple[dict[str, Array], list[Note]]:
        """Results of `run`, and limits that changed what was asked."""
        experiment = prepare(self.cut, seed=self.seed, repetition=self.repetition)
        set_up = MotorAngles(self.design).prepare(experiment)
        iterations = list(iterate(experiment, set_up, self.iterations))
        arrays = arrays_of(iterations, experiment, series=self.series)
        missing = self.iterations + 1 - len(iterations)
        found = {
            name: np.concatenate((rows, np.full((missing, *rows.shape[1:]), np.nan, rows.dtype)))
            for name, rows in arrays.items()
        }
        found |= {
            "diverged": np.array(missing > 0 or iterations[-1].diverged),
            "reached_speed": np.array(experiment.motion.reached_speed),
            "motion_end": np.array(experiment.motion_end),
            "gear": experiment.loaded.model.drives.gear,
        }
        return found, notes(experiment, iterations)


def arrays_of(
    iterations: Sequence[Iteration], experiment: Experiment, *, series: bool = True
) -> dict[str, Array]:
    """Measures and signals of iterations, as in `LearningJob.run`."""
    rows, (first, last) = list[dict[str, Any]](), experiment.motion.contour_time
    for it in iterations:
        radii = np.hypot(*it.tool.path.T)
        ripple = measures.circle_ripple(radii, last - first, *RIPPLE_BAND)
        rows.append(iteration_row(it) | {"ripple": ripple})
        if series:
            path = it.tool.path[::_PATH_STRIDE]
            signals = {"error": it.error, "correction": it.correction, "path": path}
            # Single precision is 1e-7 of an error of a milliradian: far below an encoder count.
            rows[-1] |= {name: signal.astype(np.float32) for name, signal in signals.items()}
    return {name: np.array([row[name] for row in rows]) for name in rows[0] if name != "k"}
