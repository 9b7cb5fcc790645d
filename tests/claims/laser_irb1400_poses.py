"""Motor-side learning on the IRB1400 at random poses and speeds, five updates.

Each seed is another pose, speed and individual, and other noise. The heuristic law has the design
of the robot, chosen at p1; the law on the simulated nominal robot has one chosen of cutoffs 20, 30
and 35 Hz with shifts 8, 7 and 6 at the cuts of seeds 104, 107 to 110 and 112.
"""

from collections.abc import Iterator

import numpy as np

from armside.arrays import Array
from armside.sim.laser.design import Design
from armside.sim.laser.experiment import prepare
from armside.sim.laser.learning import iterate
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.random_cuts import random_cut
from armside.sim.laser.results import iteration_row, notes
from armside.sim.laser.specification import Cut

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._learned import Learned, learned, of_rows

ROBOT = "irb1400"
LEARNED = 0.10
REPEATS = 4
SIMULATED = Design(gamma=(1.0,), delta=(6,), cutoff=(35.0,))
COLUMNS = {
    "seed": "seed",
    "speed": "speed [mm/s]",
    "heuristic": "heuristic law: worst inf-norm, k = 5",
    "first": "simulated: worst inf-norm, k = 1",
    "worst": "k = 5",
    "motor": "its motor",
    "alone": "of a run alone",
    "arm_first": "arm, k = 0 [um]",
    "arm_heuristic": "heuristic, k = 5",
    "arm_simulated": "simulated, k = 5",
}


def run(seed: int, tally: Tally) -> Iterator[Row]:
    cut = random_cut(ROBOT, seed)
    heuristic = learned(cut, seed, tally)
    simulated, alone = on_nominal(cut, seed)
    tally.add(simulated.notes)
    yield {
        "seed": seed,
        "speed": 1e3 * cut.speed,
        "heuristic": heuristic.worst("motor_inf"),
        "first": simulated.worst("motor_inf", 1),
        "worst": simulated.worst("motor_inf"),
        "motor": int(1 + simulated.normalised("motor_inf").argmax()),
        "alone": alone,
        "arm_first": heuristic.arm(0),
        "arm_heuristic": heuristic.arm(-1),
        "arm_simulated": simulated.arm(-1),
    }


def on_nominal(cut: Cut, seed: int) -> tuple[Learned, float]:
    """Measures of learning on the nominal robot, and the part of runs that they do not share.

    The second is the largest departure of a run from the mean of `REPEATS` with the last
    correction, over the largest motor error at k = 0.
    """
    experiment = prepare(cut, seed=seed)
    set_up = MotorAngles(SIMULATED, simulated=True).prepare(experiment)
    iterations = list(iterate(experiment, set_up, 5))
    found = of_rows([iteration_row(one) for one in iterations], notes(experiment, iterations))
    again = (experiment.plant.run(iterations[-1].correction) for _ in range(REPEATS))
    errors = np.array([run.recording.error for run in again])
    departure = np.abs(errors - errors.mean(axis=0)).max(axis=(0, 1))
    unbiased = np.sqrt(REPEATS / (REPEATS - 1.0)) * experiment.loaded.model.drives.gear
    return found, float(np.max(departure * np.abs(unbiased)) / found["motor_inf"][0].max())


def checks(rows: Rows) -> Iterator[Check]:
    heuristic, worst, alone = (rows[name] for name in ("heuristic", "worst", "alone"))
    words = f"learned on the nominal robot, every motor's inf-norm ends at {LEARNED:g} or below, "
    yield all_hold(f"{words}normalised as (9.5); {_words(worst)}", worst <= LEARNED)
    fewer = "every motor's inf-norm falls below that of the worst motor at k = 0"
    yield all_hold(fewer, np.maximum(worst, heuristic) < 1.0)
    below = f"its median is below that of the heuristic law ({_words(heuristic)})"
    yield all_hold(below, np.median(worst) < np.median(heuristic))
    mostly = f"where it ends above {LEARNED:g}, more than half of it is of that run alone"
    yield all_hold(mostly, (worst <= LEARNED) | (alone > 0.5 * worst))


def _words(worst: Array) -> str:
    over = f"{(worst > LEARNED).sum()} of {len(worst)} do not"
    return f"{over}, median {np.median(worst):.3f}, worst {worst.max():.3f}"


CLAIM = Claim(
    title="Motor-side learning on the IRB1400 at random poses and speeds of 12 to 77 mm/s",
    seeds=20,
    run=run,
    checks=checks,
    columns=COLUMNS,
)
