"""Targets of programs that are learned, on unseen individuals, at the tool.

Bands were written down before the judged run, of what the issue asks for. Settings were chosen on
individuals of development: the design itself with seed 100, at p1 to p3. Individuals and poses that
judge are drawn with `JUDGED_SEED`. Controllers other than the assumed one are `VIRTUAL`; that of
no maker is known.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import cycle

import numpy as np

from armside.sim.controller.programs import (
    VIRTUAL,
    PlannedProgram,
    ProgramPlant,
    learn_targets,
)
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import measure_of
from armside.sim.laser.specification import Cut
from armside.sim.motion.contour import contour_of

from ._engine import Check, Claim, Row, Rows, Tally, at_most
from ._tasks import JUDGED_SEED, tasks

UPDATES, SPACING = 3, 2e-3
TASKS = {
    "circle, radius 5 mm, 40 mm/s": Cut(speed=0.04),
    "circle, radius 20 mm, 100 mm/s": Cut(radius=0.02, speed=0.1),
    "square, 20 mm, 60 mm/s": Cut(contour=contour_of("square", 0.01), speed=0.06),
    "hexagon, 20 mm, 60 mm/s": Cut(contour=contour_of("hexagon", 0.01), speed=0.06),
}
"""Cuts by name, at drawn poses."""
BANDS = {
    "tracker": (0.10, 0.25),
    "estimate": (0.12, 0.30),
    "other": (0.15, 1.0),
}
"""Share of the uncorrected RMS after three updates: median, worst."""


def individuals(seeds: Sequence[int]) -> list[int]:
    """Drawn numbers of individuals, one a seed."""
    rng = np.random.default_rng(JUDGED_SEED + 36)
    drawn = rng.choice(np.arange(2000, 9000), 64, replace=False)
    return [int(drawn[seed]) for seed in seeds]


def cases(seeds: Sequence[int]) -> list[tuple[int, int, str, str]]:
    """Each seed has an individual, a task in turn and a pose of its own, and is run three ways."""
    names, found = cycle(TASKS), list[tuple[int, int, str, str]]()
    for seed, individual, name in zip(seeds, individuals(seeds), names, strict=False):
        found += [(seed, individual, name, how) for how in BANDS]
    return found


def run(case: tuple[int, int, str, str], tally: Tally) -> Iterator[Row]:
    seed, individual, name, how = case
    ((_, placed),) = tasks(1, JUDGED_SEED + seed)
    sensor = "estimate" if how == "estimate" else "tracker"
    imu = ImuCfg() if how == "estimate" else None
    cut = replace(TASKS[name], pose=placed.pose, individual=individual, imu=imu)
    program = PlannedProgram.of(prepare(cut, seed=seed), SPACING)
    virtual, plant = "assumed", None
    if how == "other":
        virtual = list(VIRTUAL)[seed % len(VIRTUAL)]
        plant = ProgramPlant.of(replace(program, interpolator=VIRTUAL[virtual]))
    found = list(learn_targets(program, measure_of(sensor), UPDATES, plant=plant))
    for iteration in found:
        tally.add(iteration.notes)
    first, last = found[0].tool_true, found[-1].tool_true
    offsets = program.offsets(found[-1].correction)
    yield {
        **{"seed": seed, "individual": individual, "contour": name, "learned from": sensor},
        "controller": virtual,
        "before [µm]": 1e6 * first.rms,
        "one update": found[min(1, len(found) - 1)].tool_true.rms / first.rms,
        "three": last.rms / first.rms,
        "largest deviation": last.maxdev / first.maxdev,
        "largest offset [mm]": 1e3 * float(np.linalg.norm(offsets, axis=1).max()),
        "_how": how,
    }


def checks(rows: Rows) -> Iterator[Check]:
    for how, own in rows.by("_how").items():
        median, worst = BANDS[how]
        left = own["three"]
        yield at_most(
            f"{how}, share left after three updates: median", float(np.median(left)), median
        )
        yield at_most(f"{how}, the same: worst", float(left.max()), worst)


CLAIM: Claim = Claim(
    title="Targets of programs that are learned, on unseen individuals: share of the error left",
    seeds=8,
    cases=cases,
    run=run,
    checks=checks,
    counted="learned programs",
)
