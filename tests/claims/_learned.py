"""Cuts that are learned from their motors, as claims judge them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms
from armside.sim.laser.design import Design
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import iterate
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.results import results
from armside.sim.laser.specification import Cut
from armside.sim.notes import Note, Tally

POSES = ("p1", "p2", "p3")
NAMES = ("motor_inf", "motor_two", "arm_rms", "arm_maxdev")


class Learned(dict[str, Array]):
    """Motor norms (K + 1, 6) [rad of the motor shaft] and tool deviations (K + 1,) [m]."""

    notes: Sequence[Note] = ()
    """Limits that changed the run."""

    def normalised(self, norm: str, k: int = -1) -> Array:
        """(6,) after k updates, over the largest of all motors at k = 0. Thesis (9.5)."""
        return norms.normalise(self[norm][k], self[norm][0])

    def worst(self, norm: str, k: int = -1) -> float:
        """The largest of `normalised`."""
        return float(self.normalised(norm, k).max())

    def arm(self, k: int) -> float:
        """Tool RMS [um] after k updates."""
        return 1e6 * float(self["arm_rms"][k])


def run(cut: Cut, design: Design | None = None, seed: int = 0) -> dict[str, Any]:
    """Results of a cut that is learned from its motors in five updates."""
    experiment = prepare(cut, seed=seed)
    return results(experiment, iterate(experiment, MotorAngles(design).prepare(experiment), 5))


def learned(cut: Cut, seed: int, tally: Tally, design: Design | None = None) -> Learned:
    """Measures of a cut that is learned from its motors; its notes are counted."""
    found = run(cut, design, seed)
    measures = of_rows(found["iterations"], found["notes"])
    tally.add(measures.notes)
    return measures


def of_rows(rows: Sequence[dict], notes: Sequence[Note]) -> Learned:
    """Measures from the rows of iterations."""
    measures = Learned({name: np.array([row[name] for row in rows]) for name in NAMES})
    measures.notes = notes
    return measures
