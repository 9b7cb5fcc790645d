"""Experiments on the bench of Chen and Tomizuka: learning (T1) and estimators (T3), by individual.

AMPLITUDE and CHIRP_AMPLITUDE are the one free number of each, chosen on the individuals 0 to 2.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from .dual_stage import DualStage, rms_and_peak
from .estimation.elastic_joint import chirp, dkf, kkf, measured
from .models.elastic_bench import Individual, TwoMass, run

AMPLITUDE = 0.05e-3
"""Of the transmission error [rad]: the median RMS of the first run is 0.353 of 0.354 mrad."""
CHIRP_AMPLITUDE = 0.128e-3
"""The same in T3: the median RMS of the right DKF is 0.116 mrad."""
LAWS: Mapping[str, str | None] = {"reference": None, "torque M": "motor", "torque L": "load"}
"""Side of the torque ILC beside reference ILC from the load."""
ERRORS: Mapping[str, Mapping[str, float]] = {
    "right": {},
    "k + 15 %": {"k": 1.15},
    "k - 15 %": {"k": 0.85},
    "Jl + 15 %": {"Jl": 1.15},
    "Jl - 15 %": {"Jl": 0.85},
    "k + 15 %, Jl - 15 %": {"k": 1.15, "Jl": 0.85},
    "k - 15 %, Jl + 15 %": {"k": 0.85, "Jl": 1.15},
}
"""Factors on the model's parameters."""
ESTIMATES = ("torsion", "dkf", "dkf acc", "kkf", "kkf acc", "dkf k - 20 %", "dkf k + 20 %")
"""Load angles that are compared: theta / N, estimators, DKF with Jl off by as much the other way.
"""


@dataclass(frozen=True)
class BenchLearning:
    """Ten runs of each law with one model."""

    seed: int
    error: str = "right"

    cost = 2.0

    def run(self) -> dict[str, Array]:
        """RMS and peak (10, 2) [mrad] of the load error by law."""
        individual, model = (
            Individual.drawn(self.seed, AMPLITUDE),
            TwoMass().scaled(**ERRORS[self.error]),
        )
        return {
            name: np.array(
                [rms_and_peak(e) for e, _ in DualStage(model=model, torque=side).runs(individual)]
            )
            for name, side in LAWS.items()
        }


@dataclass(frozen=True)
class BenchEstimation:
    """Estimators on the chirp."""

    seed: int

    cost = 4.0

    def run(self) -> dict[str, Array]:
        """RMS [mrad] of the load angle against the load encoder, by estimate."""
        torque, rng = chirp(), np.random.default_rng(self.seed)
        individual = Individual.drawn(self.seed, CHIRP_AMPLITUDE)
        done = run(individual, 0.0 * torque, torque, disturbed=False, closed=False)
        seen, right = measured(done, torque, rng), TwoMass()
        found = (
            done.motor / right.N,
            dkf(right, seen),
            dkf(right, seen, gyro=False),
            kkf(right, seen),
            kkf(right, seen, gyro=False),
            dkf(right.scaled(k=0.8, Jl=1.2), seen),
            dkf(right.scaled(k=1.2, Jl=0.8), seen),
        )
        rms = [1e3 * np.sqrt(np.mean((one - done.load) ** 2)) for one in found]
        return {name: np.array(size) for name, size in zip(ESTIMATES, rms, strict=True)}
