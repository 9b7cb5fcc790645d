"""Designs from learning data of the robots of `robots`, at their training poses."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from armside.sim.robot_file.find import find_cell

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from .laser_irb1400_design import designed
from .robots import ROBOTS

TRAINING_SEED = 100
"""Added to a seed: no individual that is judged has been trained on."""


def cases(seeds: Sequence[int]) -> Iterator[tuple[str, int]]:
    yield from product(ROBOTS, (TRAINING_SEED + seed for seed in seeds))


def run(case: tuple[str, int], _: Tally) -> Iterator[Row]:
    name, seed = case
    cells = designed(ROBOTS[name].cut(ROBOTS[name].training), seed)
    yield {"seed": seed, "robot": name} | {k: v for k, v in cells.items() if k != "static gain"}


def checks(rows: Rows) -> Iterator[Check]:
    for name, own in rows.by("robot").items():
        gamma, delta, cutoff = np.median(own.of("gamma", "delta", "cutoff [Hz]"), axis=0)
        of_file = find_cell(ROBOTS[name].path).learning
        asked = f"gamma {gamma:.2f}, delta {delta:g}, cutoff {cutoff:g} Hz"
        same = of_file is not None and (of_file.delta, of_file.cutoff) == (delta, cutoff)
        near = of_file is not None and abs(of_file.gamma - gamma) <= 0.05
        yield all_hold(f"{name}: its file has the medians {asked}", [same, near])


CLAIM = Claim(
    title="The designs that learning data of the robots ask for, at their training poses",
    seeds=3,
    cases=cases,
    run=run,
    checks=checks,
)
