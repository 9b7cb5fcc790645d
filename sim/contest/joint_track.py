"""Track `joint`: the two-mass joint of chapter 8 with unknown parameters, friction and noise.

An entry sees the motor; so does the score, without the encoder's noise. No MuJoCo.
"""

import copy
from dataclasses import asdict, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.models.two_mass import FrictionPlant, TwoMassLoop, step_reference

from .seal import Round
from .task import Drawn, Limits, Ranges, Task, Track

AT = (5, 10, 40)
"""Runs k whose errors are scored."""
SAMPLES = 800
LARGEST = 1.0
"""Largest correction over the largest angle of the reference, in size and from one sample to the
next. ESTIMATE"""
RANGES: Ranges = {
    "k": ((0.7, 1.5), (0.5, 2.0)),
    "Ja": ((0.7, 1.4), (0.6, 1.7)),
    "Jm": ((0.85, 1.2), (0.8, 1.3)),
    "d": ((0.5, 2.0), (0.4, 2.5)),
    "fm": ((0.7, 1.4), (0.6, 1.6)),
    "kt": ((0.9, 1.1), (0.85, 1.15)),
    "coulomb": ((0.0, 0.01), (0.0, 0.02)),
    "noise": ((1e-4, 1e-3), (1e-4, 2e-3)),
    "move": ((0.5, 1.0), (0.4, 1.25)),
    "angle": ((0.5, 1.5), (0.4, 2.0)),
}
"""Factors on Table 8.1 with uniform logarithm; dry friction [N m] and encoder noise [rad], motor
side; duration [s] and size [rad] of the arm's move. ESTIMATES."""


def draw(round: Round, index: int) -> Task:
    """Task of a round by its index; drawn again where the controller could not hold the joint."""
    drawn = Drawn(RANGES, round, "joint", index)
    nominal = TwoMassLoop()
    while True:
        names = ("k", "Ja", "Jm", "d", "fm", "kt")
        factors = {name: getattr(nominal.joint, name) * drawn.log(name) for name in names}
        loop = replace(
            nominal, joint=replace(nominal.joint, **factors), reference_model=nominal.joint
        )
        box = int(0.5 * drawn.log("move") / nominal.sample_time)
        arm = drawn.log("angle") * step_reference(SAMPLES, nominal.sample_time, box=box)
        noise, coulomb = drawn.log("noise"), drawn("coulomb")
        try:
            plant = FrictionPlant(
                loop=loop, arm_reference=arm, coulomb=coulomb, noise=noise, rng=drawn.rng
            )
            break
        except ValueError:  # an unstable loop
            continue
    return _task(plant, nominal, round.key("joint", index, "entry") % 2**32)


def _task(plant: FrictionPlant, nominal: TwoMassLoop, seed: int) -> Task:
    r = plant.motor_reference
    most = LARGEST * np.abs(r).max(axis=0)
    limits = Limits(correction=most, change=most)

    def run(k: int, correction: Array) -> tuple[dict[str, Array], float]:
        assert plant.rng is not None
        same = copy.deepcopy(plant.rng)
        measured = plant.run(correction).motor
        true = r - (measured - same.normal(0.0, plant.noise, len(r))[:, None])
        records = {"error": r - measured, "correction": correction}
        return records, float(np.sqrt(np.mean(np.square(true))))

    given = {
        **{"track": "joint", "reference": r, "path": plant.arm_reference, "runs": AT[-1] + 1},
        **{"sample_time": nominal.sample_time, "seed": seed},
        "nominal": _parameters(nominal),
        "limits": vars(limits),
    }
    return Task(
        given=given, limits=limits, run=run, plain=lambda: np.array([run(0, np.zeros_like(r))[1]])
    )


def _parameters(loop: TwoMassLoop) -> dict[str, float]:
    """Parameters of joint and controller by name, SI units."""
    return asdict(loop.joint) | asdict(loop.controller)


def left(errors: Array, plain: Array) -> float:
    """Geometric mean of what is left at AT; after an entry has stopped its last run counts."""
    at = [errors[min(k, len(errors) - 1)] for k in AT]
    return float(np.exp(np.mean(np.log(at)))) / float(plain[0])


TRACK = Track(
    name="joint",
    runs=AT[-1] + 1,
    seconds=60.0,
    draw=draw,
    left=left,
    score="motor error left at k = 5, 10 and 40, geometric mean",
    ranges=RANGES,
)
