"""Individuals that commissioning cannot tell from a twin, and their errors with a correction.

Members are drawn from the posterior of the parameters. What bends in a way that no parameter knows
shows as a residual of held-out cuts: the larger it is, the more the compliances of the members
differ. Damping, which is not identified, is drawn from the spread of the production line.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from armside.arrays import Array

from ..laser.experiment import Experiment
from ..robot.individual import Individual
from ..robot.six_axes import N_AXES
from ..robot.spread import PRODUCTION
from .learning import twin_error
from .parameters import SPRINGS, Parameters
from .sensors import Measure
from .simulation import Design

MEMBERS = 8
"""Two for each core of a small machine four times over: half a second. ESTIMATE."""
SAMPLES_AT_ONCE = 20_000
"""Samples of the log of all runs of one rollout together: 80 s of motion, 250 MB."""
_LOOSENESS: Mapping[Measure, float] = {"tracker": 5e3, "imu": 0.0}
"""[1/m]: log(compliance) for each metre of residual, 5 % for 10 um. From individuals 1001 to 1012,
which are not the judged ones. By the tracker 5e3 ranks their errors best among 0, 2.5e3, 5e3 and
1e4. The residual of an IMU is its own noise: of 0 the predicted errors follow those of the
individuals, long contours above short ones, and 5e3 hides that."""
_SEED = 0xE5


def members(
    parameters: Parameters,
    theta: Array,
    covariance: Array,
    gear_phase: Array,
    residual: float,
    sensor: Measure,
    count: int = MEMBERS,
) -> list[Individual]:
    """Individuals drawn around a twin, the same ones each time.

    residual: of cuts that the twin was not identified from [m], by the sensor.
    """
    rng, loose = np.random.default_rng(_SEED), _LOOSENESS[sensor] * residual
    root = np.linalg.cholesky(covariance + 1e-12 * np.diag(parameters.standard_deviation**2))
    found = []
    for _ in range(count):
        drawn = theta + root @ rng.standard_normal(len(theta))
        for name in SPRINGS:
            at = parameters.at(name)
            factor = np.exp(loose * rng.standard_normal(at.stop - at.start))
            drawn[at] = (1.0 + drawn[at]) * factor - 1.0
        inside = np.clip(drawn, parameters.lower, parameters.upper)
        member = parameters.individual(inside, gear_phase)
        damping = np.exp(PRODUCTION.damping * rng.standard_normal(N_AXES))
        found.append(replace(member, gear_damping=damping))
    return found


def errors(
    design: Design,
    individuals: Sequence[Individual],
    experiment: Experiment,
    correction: Array,
) -> Array:
    """(n,) [m], tool error of each individual with a correction."""
    reference = experiment.loaded.reference
    at_once = max(1, int(SAMPLES_AT_ONCE / len(reference)))
    found = list[float]()
    for i in range(0, len(individuals), at_once):
        runs = design.run(individuals[i : i + at_once], reference, correction)
        found += [twin_error(experiment, run) for run in runs]
    return np.array(found)
