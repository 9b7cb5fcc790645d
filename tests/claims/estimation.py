"""The arm estimated, and learned from the estimate: p1, p2, p3; 40 mm/s and fast; ten updates.

Each seed is another individual, another IMU screwed on differently with its clock off by up to
10 ms, another assumed stiffness (each axis wrong by up to 30 %), and other noise.

`estimation-irb1400`: that robot at its poses, 40 mm/s, five updates, all gear effects; the pass
band of the law was chosen at seeds from 100 on. `estimation-arms`: likewise every robot file beside
those of the thesis; nothing was chosen on these arms.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from armside.assets import IRB1400_XML
from armside.sim.laser.specification import Cut
from armside.sim.motion.timing import PathLimits
from armside.sim.robot.effects import Effect
from armside.sim.robot_file.find import find_cell

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_most, crossed
from ._estimates import COMPARED, case, from_estimate, from_motors, from_tracker
from ._learned import POSES

FIVE, TEN = 5, 10
LENGTHS = {
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


def run(one: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, pose = one
    default = case(Cut(pose=pose), seed)
    springs = replace(default, cut=replace(default.cut, without=tuple(Effect)))
    fast = replace(springs, cut=replace(springs.cut, speed=0.1))
    faster = replace(fast, cut=replace(fast.cut, limits=PathLimits(acceleration=2.2)))
    base = from_estimate(springs, TEN, tally)
    tracked = from_tracker(base, FIVE, tally)
    every = from_estimate(default, TEN, tally)
    hard = replace(COMPARED, payload_error=-5.0, damping_factor=1.5)
    worst = from_estimate(default, TEN, tally, hard)
    quick, quicker = (from_estimate(each, FIVE, tally) for each in (fast, faster))
    s, d, f, g = (
        from_motors(each, FIVE, tally).um[-1] for each in (springs, default, fast, faster)
    )
    lengths = [
        *base.errors(),
        *(base.um[0], s, base.um[FIVE], base.um[-1], tracked.um[-1]),
        *(every.um[0], d, every.um[FIVE], every.um[-1], worst.um[0], worst.um[-1]),
        *(quick.um[0], f, quick.um[-1], quicker.um[0], g, quicker.um[-1]),
    ]
    diverged = any(each.diverged for each in (base, tracked, every, worst, quick, quicker))
    row = {"seed": seed, "pose": pose} | dict(zip(LENGTHS, lengths, strict=True))
    yield row | {"diverged": diverged}


def checks(rows: Rows) -> Iterator[Check]:
    for statement, one, other, bar in BARS:
        worst = (rows[one] / rows[other]).max()
        yield at_most(statement, worst, bar, label="worst ")
    hard, allowed = rows["hard_10"], np.maximum(0.12 * rows["hard_start"], 30.0)
    larger = "hard case after ten: at most 0.12 of k = 0 or 30 µm, whichever is larger"
    yield all_hold(f"{larger} (worst {hard.max():.0f} µm)", hard <= allowed)
    below = [rows[estimate] < rows[motor] for estimate, motor in BEATEN]
    yield all_hold("estimate below motor side in every case", below)
    yield all_hold("no case diverges", ~rows["diverged"])


CLAIM = Claim(
    title="Learning from an estimate of the tool: tool deviation RMS in µm",
    seeds=10,
    cases=crossed(POSES),
    run=run,
    checks=checks,
    columns={"seed": "seed", "pose": "pose"} | LENGTHS | {"diverged": "any diverged"},
    counted="learned cuts",
)


LEFT = 0.20
"""Largest fraction of k = 0 that the estimate leaves."""
COLUMNS = {
    **{name: name for name in ("seed", "robot", "pose")},
    "rigid": "error of motor-angle kinematics (3D)",
    "estimate": "error of the estimate (3D)",
    "start": "k = 0",
    "motor": "motor k = 5",
    "learned": "estimate k = 5",
    "tracked": "tracker k = 5",
    "diverged": "any diverged",
}
"""Lengths [um] of one cut, by the tracker but for the first two."""
Place = tuple[int, str, str]
"""Seed, robot or its file, pose."""


def at_poses(robots: Sequence[str], seeds: Sequence[int]) -> Iterator[Place]:
    """Robots at each of their poses."""
    places = [(robot, pose) for robot in robots for pose in find_cell(robot).poses]
    yield from ((seed, *place) for seed, place in product(seeds, places))


def run_arm(place: Place, tally: Tally) -> Iterator[Row]:
    """One cut learned from estimate, tracker and motors."""
    seed, robot, pose = place
    of = case(Cut(robot=robot, pose=pose), seed)
    learned = from_estimate(of, FIVE, tally)
    tracked = from_tracker(learned, FIVE, tally)
    rigid, estimate = learned.errors()
    yield {
        **{"seed": seed, "robot": Path(robot).stem, "pose": pose},
        **{"rigid": rigid, "estimate": estimate, "start": learned.um[0]},
        "motor": from_motors(of, FIVE, tally).um[-1],
        **{"learned": learned.um[-1], "tracked": tracked.um[-1]},
        "diverged": learned.diverged or tracked.diverged,
    }


def checks_irb1400(rows: Rows) -> Iterator[Check]:
    left = rows["learned"] / rows["start"]
    words = f"the estimate leaves at most {LEFT:g} of k = 0 (worst {left.max():.3f}"
    median = np.median(left)
    yield Check("", f"{words}, median {median:.3f})", "", left.max(), high=LEFT)
    yield from of_every_arm(rows)


def of_every_arm(rows: Rows) -> Iterator[Check]:
    """Checks of the tool after learning from the estimate, over that after learning from motors."""
    for robot, own in rows.by("robot").items():
        over = own["learned"] / own["motor"]
        words = f"worst {over.max():.2f} of it, median {np.median(over):.2f}"
        yield all_hold(f"{robot}: estimate below motor side in every case ({words})", over < 1.0)
    yield all_hold("no case diverges", ~rows["diverged"])


CLAIM_IRB1400 = Claim(
    title="Learning from an estimate of the tool on the IRB1400: tool deviation RMS in µm",
    seeds=10,
    cases=partial(at_poses, ["irb1400"]),
    run=run_arm,
    checks=checks_irb1400,
    columns=COLUMNS,
    counted="learned cuts",
)


def robot_files() -> Sequence[Path]:
    """Robot files that ship beside the robots of the thesis."""
    thesis = ("irb1400.toml", "large_robot.toml")
    return [file for file in sorted(IRB1400_XML.parent.glob("*.toml")) if file.name not in thesis]


CLAIM_ARMS = replace(
    CLAIM_IRB1400,
    title="Learning from an estimate of the tool on other arms: tool deviation RMS in µm",
    seeds=2,
    cases=partial(at_poses, [str(file) for file in robot_files()]),
    checks=of_every_arm,
)
