"""Learning from scans of the parts alone, and with springs that an IMU on loan has identified.

Ten individuals with geometry errors, twelve tasks each: `_tasks`. "Left" is the true tool RMS after
k parts over that of the first. Law and band were chosen on individuals of development.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import learn
from armside.sim.laser.measures import Measure, MotorAngles
from armside.sim.laser.results import pass_notes
from armside.sim.laser.scan_measure import ScannedPart
from armside.sim.motion.tool_motion import motion_notes
from armside.sim.robot.spread import Drawn

from ._engine import Check, Claim, Row, Rows, Tally, crossed
from ._tasks import JUDGED_BY_SCAN, JUDGED_SEED, tasks

N_TASKS, PARTS = 12, 5


class Asked(NamedTuple):
    """Of what is left after some parts: median and worst."""

    measure: Measure
    after: Mapping[int, tuple[float, float]]


MEASURES: Mapping[str, Asked] = {
    "scan alone": Asked(ScannedPart(), {3: (0.15, 0.35), 5: (0.10, 0.25)}),
    "scan, springs known": Asked(ScannedPart(imu=ImuCfg()), {2: (0.08, 0.20), 5: (0.05, 0.12)}),
    "motors": Asked(MotorAngles(), {}),
}


def run(case: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, name = case
    number = JUDGED_BY_SCAN[seed % len(JUDGED_BY_SCAN)]
    left = learned(number, name, JUDGED_SEED, N_TASKS, tally)
    middle, worst = np.median(left, axis=0), left.max(axis=0)
    yield {
        **{"individual": number, "learned from": name},
        **{f"median left after {k}": float(middle[k]) for k in range(1, PARTS + 1)},
        **{f"worst left after {k}": float(worst[k]) for k in (2, 3, 5)},
        "_left": left,
    }


def learned(number: int, name: str, seed: int, n_tasks: int, tally: Tally) -> np.ndarray:
    """(n_tasks, PARTS + 1), left after each part; of a loop that diverged the last one stays."""
    rows = []
    for i, (_, cut) in enumerate(tasks(n_tasks, seed + number)):
        own = 100 * number + i  # each task has a scanner, assumed springs and noise of its own
        measure = MEASURES[name].measure
        mine = replace(cut, individual=Drawn(number), imu=measure.imu)
        experiment, rms = prepare(mine, seed=own), list[float]()
        tally.add(motion_notes(experiment.motion, mine.limits))
        for iteration in learn(mine, measure=measure, iterations=PARTS, seed=own):
            rms.append(iteration.tool_true.rms)
            tally.add(pass_notes(experiment, iteration.run))
        rms += [rms[-1]] * (PARTS + 1 - len(rms))
        rows.append(np.array(rms) / rms[0])
    return np.array(rows)


def checks(rows: Rows) -> Iterator[Check]:
    for name, of in rows.by("learned from").items():
        left = of.joined("_left")
        for k, (median, worst) in MEASURES[name].after.items():
            what = f"{name}, after {k} parts"
            yield Check("", f"{what}: median left", "", float(np.median(left[:, k])), high=median)
            yield Check("", f"{what}: worst left", "", float(left[:, k].max()), high=worst)


CLAIM = Claim(
    title="Learning from scans of the parts",
    seeds=len(JUDGED_BY_SCAN),
    cases=crossed(MEASURES),
    run=run,
    checks=checks,
)
