"""The claim of `armside verify chapter9`: the bands of chapter 9 over robots, with all noise."""

from collections.abc import Iterable

import numpy as np

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic

from ..commands.verify import Table, Verdict
from ..jobs.store import Result
from ..jobs.workers import Workers
from ..learning_job import LearningJob
from ..thesis.chapter9 import bands
from ..thesis.chapter9.bands import POSES, SAMPLE_TIME
from ..thesis.chapter9.sections import MOST_MOVED, SPEEDS, identify
from ..thesis.chapter9.table import STUDIES, Study
from ..thesis.report import Check

FRACTION = 0.8
"""Of the seeds, at which each band must hold: four of five."""

_VELOCITY = Study(
    what="the ends of Fig 9.6",
    fixed={"iterations": 0},
    over={"speed": (10.0, 80.0, 100.0), "pose": POSES},
)
_REPEATED = Study(what="(9.10)", over={"pose": ("p1",)}, repetitions=2)


def experiments(seed: int) -> dict[str, dict]:
    """All experiments that the bands need, by study."""
    named = ("position", "stability", "identification", "operating point", "shift, arm", "cutoff")
    studies = {name: STUDIES[name] for name in named}
    studies |= {"velocity": _VELOCITY, "repeatability": _REPEATED}
    return {name: study.jobs(seed) for name, study in studies.items()}


def checks(results: dict[str, dict]) -> list[Check]:
    """Every band of chapter 9 from the results of `experiments`."""
    base, cutoff = results["operating point"], results["cutoff"]
    data = results["identification"]
    model = identify({v: data["p1", v] for v in SPEEDS})
    law = Heuristic(Q=ZeroPhaseButterworth(10.0, SAMPLE_TIME), gamma=0.9, delta=3)
    at_40 = {pose: data[pose, 40.0] for pose in ("p1", "p2")}
    shift_3, shift_6 = (
        {pose: results["shift, arm"][pose, delta] for pose in ("p1", "p2")} for delta in (3, 6)
    )
    by_speed = {
        speed: {pose: results["velocity"][speed, pose] for pose in POSES}
        for speed in _VELOCITY.over["speed"]
    }
    first, second = (results["repeatability"]["p1", repetition] for repetition in (0, 1))
    slow, fast = (cutoff["p1", frequency] for frequency in (10.0, 15.0))
    return [
        *bands.motor_side(base),
        *bands.stability(results["stability"]),
        *bands.predicted_rates(model.system, at_40, law, MOST_MOVED),
        *bands.arm_side(base),
        *bands.cutoff_arm(slow, fast),
        *bands.cutoff_motor(slow, fast),
        *bands.shift_arm(shift_3, shift_6),
        *bands.fitted_model(model),
        *bands.criterion_of(),
        *bands.nominal_by_position(results["position"]),
        *bands.nominal_by_velocity(by_speed),
        *bands.repeatability(first, second),
    ]


def found(seed: int, workers: Workers) -> list[Check]:
    """Run what the bands need for one seed and compare."""
    jobs = experiments(seed)
    distinct = sorted({job for study in jobs.values() for job in study.values()}, key=_longest)
    results = dict(zip(distinct, workers.map(_run, distinct), strict=True))
    return checks(
        {name: {key: results[job] for key, job in study.items()} for name, study in jobs.items()}
    )


def chapter9(seeds: Iterable[int]) -> Table:
    """One column per seed: another individual (friction +-2 %), tracker set-up and noise."""
    by_seed: dict[int, list[Check]] = {}
    with Workers() as workers:
        for seed in seeds:
            by_seed[seed] = found(seed, workers)
    by_check = list(zip(*by_seed.values(), strict=True))
    holding = [sum(check.holds for check in row) for row in by_check]
    return Table(
        title="Chapter 9: what the robot does, over robots and noise",
        columns=("", "what", "thesis", "band", *(f"seed {seed}" for seed in by_seed), "holds"),
        rows=[
            (
                row[0].id,
                row[0].statement,
                row[0].thesis,
                row[0].band,
                *(check.ours for check in row),
                f"{n} of {len(row)}",
            )
            for row, n in zip(by_check, holding, strict=True)
        ],
        verdicts=[
            Verdict(
                f"{row[0].id}: {row[0].statement}: {row[0].band}, for at least "
                f"{100 * FRACTION:.0f} % of the seeds ({n} of {len(row)})",
                n >= np.ceil(FRACTION * len(row)),
            )
            for row, n in zip(by_check, holding, strict=True)
        ],
    )


def _run(job: LearningJob) -> Result:
    return job.run()


def _longest(job: LearningJob) -> float:
    return -job.cost
