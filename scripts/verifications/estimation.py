"""The claims of `armside verify estimation`: the arm estimated, and learned from the estimate.

Each seed is another individual, another IMU screwed on differently with its clock off by up to
10 ms, another assumed stiffness (each axis wrong by up to 30 %), and other noise.
"""

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np

from armside.sim.cut.timing import PathLimits
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case, rms
from armside.sim.laser.path_error import path_error, rigid_path
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import Source
from armside.sim.notes import Tally
from armside.sim.robot.effects import Effect

from ..jobs.workers import Workers

POSES = ("p1", "p2", "p3")
FIVE, TEN = 5, 10
COLUMNS = {
    "forward_kinematics": "error of motor-angle kinematics (3D)",
    "estimate": "error of the estimate (3D)",
    "start": "springs: k = 0",
    "motor_5": "motor k = 5",
    "estimate_5": "estimate k = 5",
    "estimate_10": "estimate k = 10",
    "tracker_5": "tracker k = 5",
    "default_start": "all gear effects: k = 0",
    "default_motor_5": "motor k = 5",
    "default_5": "estimate k = 5",
    "default_10": "estimate k = 10",
    "hard_start": "hard: k = 0",
    "hard_10": "estimate k = 10",
    "fast_start": "81 mm/s: k = 0",
    "fast_motor": "motor k = 5",
    "fast_estimate": "estimate k = 5",
    "faster_start": "100 mm/s: k = 0",
    "faster_motor": "motor k = 5",
    "faster_estimate": "estimate k = 5",
}
"""Lengths [um] of one seed at one pose."""
Row = tuple[int, str, dict[str, float], bool]
"""Seed, pose, lengths [um] by `COLUMNS`, and whether any case diverged."""
BARS = (
    ("error of the estimate over that of motor-angle kinematics", "estimate",
     "forward_kinematics", 1 / 5),
    ("springs, estimate after five updates over k = 0", "estimate_5", "start", 0.15),
    ("springs, estimate after ten over k = 0", "estimate_10", "start", 0.10),
    ("springs, tracker after five over k = 0", "tracker_5", "start", 0.10),
    ("all gear effects, estimate after five over k = 0", "default_5", "default_start", 0.15),
    ("all gear effects, estimate after ten over k = 0", "default_10", "default_start", 0.15),
    ("81 mm/s, estimate over k = 0", "fast_estimate", "fast_start", 0.15),
    ("100 mm/s, estimate over k = 0", "faster_estimate", "faster_start", 0.15),
)  # fmt: skip
"""Ratios of two lengths that are bounded, in every row."""
BEATEN = (
    ("estimate_5", "motor_5"),
    ("default_5", "default_motor_5"),
    ("fast_estimate", "fast_motor"),
    ("faster_estimate", "faster_motor"),
)
"""Lengths of which the first is the smaller."""


def estimation(seeds: Iterable[int]) -> Table:
    """p1, p2, p3; 40 mm/s and fast; ten updates."""
    said = Tally()
    with Workers() as workers:
        found = workers.map(_row, list(product(seeds, POSES)))
    rows = [row for row, _ in found]
    for _, of_row in found:
        said.include(of_row)
    return Table(
        "Learning from an estimate of the tool: tool deviation RMS in µm",
        ("seed", "pose", *COLUMNS.values(), "any diverged"),
        [(seed, pose, *lengths.values(), diverged) for seed, pose, lengths, diverged in rows],
        verdicts(rows),
        said.notes("learned cuts"),
    )


def _row(case: tuple[int, str]) -> tuple[Row, Tally]:
    said = Tally()
    return row(*case, said), said


def row(seed: int, pose: str, said: Tally) -> Row:
    """All cases of one seed at one pose; notes of the cuts that are learned are counted."""
    cut = Cut(pose=pose, imu=ImuCfg())
    springs = Case(cut=replace(cut, without=tuple(Effect)), seed=seed)
    output, learned = springs.from_tool(TEN)
    base = list(learned)
    first = base[0].run
    by_tracker = replace(COMPARED, source=Source.TRACKER)
    tracked = list(springs.from_tool(FIVE, by_tracker, output.known.springs)[1])

    default = Case(cut=cut, seed=seed)
    hard = replace(COMPARED, payload_error=-5.0, damping_factor=1.5)
    all_effects, worst = (list(default.from_tool(TEN, by)[1]) for by in (COMPARED, hard))
    fast = replace(springs, cut=replace(springs.cut, speed=0.1))
    faster = replace(fast, cut=replace(fast.cut, limits=PathLimits(acceleration=2.2)))
    quick, quicker = (list(case.from_tool(FIVE)[1]) for case in (fast, faster))
    cases = (springs, default, fast, faster)
    by_motors = [list(case.from_motors(FIVE)) for case in cases]
    motor, default_motor, fast_motor, faster_motor = (rms(runs)[-1] for runs in by_motors)
    all_runs = (base, tracked, all_effects, worst, quick, quicker)
    from_tool = (springs, springs, default, default, fast, faster)
    for case, runs in zip((*from_tool, *cases), (*all_runs, *by_motors), strict=True):
        said.add(notes(case.experiment(), runs))
    s, t, d, h, f, g = map(rms, all_runs)
    lengths = [
        *(path_error(path, first) for path in (rigid_path(first), output(first))),
        *(s[0], motor, s[FIVE], s[-1], t[-1]),
        *(d[0], default_motor, d[FIVE], d[-1], h[0], h[-1]),
        *(f[0], fast_motor, f[-1], g[0], faster_motor, g[-1]),
    ]
    in_um = {name: 1e6 * length for name, length in zip(COLUMNS, lengths, strict=True)}
    return seed, pose, in_um, any(runs[-1].diverged for runs in all_runs)


def verdicts(rows: list[Row]) -> list[Check]:
    """The checks of all rows."""
    column = {name: np.array([lengths[name] for _, _, lengths, _ in rows]) for name in COLUMNS}

    def bounded(statement: str, one: str, other: str, bar: float) -> Check:
        worst = (column[one] / column[other]).max()
        words = f"{statement}: at most {bar:g} (worst {worst:.3f})"
        return Check("", words, "", worst, high=bar)

    hard, allowed = column["hard_10"], np.maximum(0.12 * column["hard_start"], 30.0)
    larger = "hard case after ten: at most 0.12 of k = 0 or 30 µm, whichever is larger"
    below = [column[estimate] < column[motor] for estimate, motor in BEATEN]
    return [
        *(bounded(*bar) for bar in BARS),
        all_hold(f"{larger} (worst {hard.max():.0f} µm)", hard <= allowed),
        all_hold("estimate below motor side in every case", below),
        all_hold("no case diverges", [not diverged for *_, diverged in rows]),
    ]
