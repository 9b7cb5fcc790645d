"""The claim of `armside verify chapter9`: the bands of chapter 9 over robots, with all noise."""

from collections.abc import Iterable
from dataclasses import replace

from armside.sim.calibration import bands
from armside.sim.calibration.bands import MOST_MOVED, POSES, SPEEDS
from armside.sim.evaluation.check import Check, Table, over_seeds
from armside.sim.laser.job import LearningJob
from armside.sim.notes import Tally

from ..jobs.workers import Workers
from ..thesis.chapter9.identification import LAW
from ..thesis.chapter9.table import STUDIES, Study

FRACTION = 0.8  # fraction of the seeds at which each band must hold: four of five
NAMED = ("position", "stability", "identification", "operating point", "shift, arm", "cutoff")
EXPERIMENTS = {name: STUDIES[name] for name in NAMED} | {
    "velocity": Study({"speed": (10.0, 80.0, 100.0), "pose": POSES}, {"iterations": 0}),
    "repeatability": Study({"pose": ("p1",)}, repetitions=2),
}
"""All experiments that the bands need."""


def checks(results: dict[str, dict]) -> list[Check]:
    """Every band of chapter 9 from the results of `EXPERIMENTS`."""
    base, cutoff = results["operating point"], results["cutoff"]
    data = results["identification"]
    at_p1 = {v: data["p1", v] for v in SPEEDS}
    model = bands.identify(at_p1)
    at_40 = {pose: data[pose, 40.0] for pose in ("p1", "p2")}
    shifted = results["shift, arm"]
    delta_3, delta_6 = ({pose: shifted[pose, d] for pose in ("p1", "p2")} for d in (3, 6))
    at_10, at_80, at_100 = (
        {pose: results["velocity"][speed, pose] for pose in POSES} for speed in (10.0, 80.0, 100.0)
    )
    first, second = (results["repeatability"]["p1", repetition] for repetition in (0, 1))
    slow, fast = (cutoff["p1", frequency] for frequency in (10.0, 15.0))
    return [
        *bands.motor_side(base),
        *bands.stability(results["stability"]),
        *bands.predicted_rates(model.system, at_40, LAW, MOST_MOVED),
        *bands.arm_side(base),
        *bands.cutoff_arm(slow, fast),
        *bands.cutoff_motor(slow, fast),
        *bands.shift_arm(delta_3, delta_6),
        *bands.fitted_model(at_p1),
        *bands.criterion_of(),
        *bands.nominal_by_position(results["position"]),
        *bands.growth(at_10, at_80),
        *bands.saturation(at_80, at_100),
        *bands.repeatability(first, second),
    ]


def found(seed: int, workers: Workers, said: Tally) -> list[Check]:
    """Run the experiments of one seed and compare; notes are counted."""
    jobs = {name: study.jobs(seed) for name, study in EXPERIMENTS.items()}
    every = {job for study in jobs.values() for job in study.values()}
    distinct = sorted(every, key=lambda job: -job.cost)  # the longest first
    results = {}
    for job, (arrays, notes) in zip(
        distinct, workers.map(LearningJob.noted, distinct), strict=True
    ):
        results[job] = arrays
        said.add(notes)
    return checks(
        {name: {key: results[job] for key, job in study.items()} for name, study in jobs.items()}
    )


def chapter9(seeds: Iterable[int]) -> Table:
    """One column per seed: another individual (friction +-2 %), tracker set-up and noise."""
    said = Tally()
    with Workers() as workers:
        by_seed = {seed: found(seed, workers, said) for seed in seeds}
    title = "Chapter 9: what the robot does, over robots and noise"
    return replace(over_seeds(title, by_seed, FRACTION), notes=said.notes("experiments"))
