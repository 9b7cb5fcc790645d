"""The bands of chapter 9 over noise: one robot, of friction +-2 %, and its tracker set-up.

`armside reproduce F07` has a hundred robots.
"""

from collections.abc import Iterator

from armside.scripts.thesis.chapter9 import bands
from armside.scripts.thesis.chapter9.bands import MOST_MOVED, POSES, SPEEDS
from armside.scripts.thesis.chapter9.response import LAW
from armside.scripts.thesis.chapter9.table import STUDIES, Study

from ._engine import Check, Claim, Row, Rows, Tally
from ._seeds import held

FRACTION = 0.8  # fraction of the seeds at which each band must hold: four of five
NAMED = ("position", "identification", "operating point", "shift, arm", "cutoff")
EXPERIMENTS = {name: STUDIES[name] for name in NAMED} | {
    "velocity": Study({"speed": (10.0, 80.0, 100.0), "pose": POSES}, {"iterations": 0}),
    "repeatability": Study({"pose": ("p1",)}, repetitions=2),
}
"""All experiments that the bands need."""


def bands_of(results: dict[str, dict]) -> list[Check]:
    """Bands of chapter 9 that hold; a5, c4, d3 do not (`armside reproduce 9.7 9.14 9.12`)."""
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


def run(seed: int, tally: Tally) -> Iterator[Row]:
    yield {"seed": seed, "checks": bands_of(results(seed, tally))}


def results(seed: int, tally: Tally) -> dict[str, dict]:
    """Results of the experiments of one seed; notes are counted."""
    jobs = {name: study.jobs(seed) for name, study in EXPERIMENTS.items()}
    found = {}
    for job in dict.fromkeys(job for study in jobs.values() for job in study.values()):
        found[job], notes = job.noted()
        tally.add(notes)
    return {name: {key: found[job] for key, job in of.items()} for name, of in jobs.items()}


def shown(rows: Rows) -> Iterator[Row]:
    by_seed = [row["checks"] for row in rows]
    for verdict, *of in zip(checks(rows), *by_seed, strict=True):
        one = of[0]
        words = {"": one.id, "what": one.statement, "thesis": one.thesis, "band": one.band}
        ours = {f"seed {row['seed']}": c.ours for row, c in zip(rows, of, strict=True)}
        yield words | ours | {"holds": f"{verdict.ours:.0f} of {len(rows)}"}


def checks(rows: Rows) -> list[Check]:
    return held({row["seed"]: row["checks"] for row in rows}, FRACTION)


CLAIM = Claim(
    title="Chapter 9: five noises of one robot",
    seeds=5,
    run=run,
    checks=checks,
    shown=shown,
    counted="experiments",
)
