"""Fast, hard motion learned from the estimate: 0.3 to 1 m/s, three arms, three poses; five updates.

Each seed draws a task for each arm: a circle, a square with rounded corners, or a square of four
strokes from rest to rest, its size, speed and acceleration, at one of three poses. A task whose
plan stays below 0.3 m/s, for its joints or drives, is drawn again. Individuals, units at the tool
and noise are those of seeds from `FIRST` on; settings were chosen on `DEVELOPMENT`.

Before: the law's pass band and the bound on what springs leave unexplained as they were for any
motion, on the same springs.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from armside.sim.cell import CELLS, ToolPose
from armside.sim.estimation.arm_filter import FRACTION
from armside.sim.estimation.elasticity import SpringPrior
from armside.sim.estimation.imu_health import ImuError
from armside.sim.estimation.tool_law import ToolLaw, pass_band
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.laser.strokes import ROBOTS, Strokes
from armside.sim.motion.contour import Circle, square
from armside.sim.motion.timing import PathLimits
from armside.sim.robot_file.find import find_cell

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_most, crossed
from ._estimates import BY_TRACKER, Learned, from_estimate
from ._learned import POSES

DEVELOPMENT = tuple(range(10))
"""Seeds and individuals on which causes were separated and settings chosen: squares of 100 mm with
rounded corners at 2.2 to 12.5 m/s^2, a circle of radius 30 mm, strokes of 100 and 250 mm."""
FIRST = 200
"""Seed and individual of the claim's seed 0."""
_DRAWS = 50
_ACROSS = (0.70710678118, 0.0, 0.70710678118, 0.0)
_DOWN = CELLS["large"].poses["p2"].quaternion
ARMS: dict[str, tuple[ToolPose | str, ...]] = {
    "large": (
        ToolPose((1.50, 0.10, 1.5992), _DOWN),
        "p2",
        ToolPose((1.80, -0.40, 1.5992), _DOWN),
    ),
    "kr16_like.toml": POSES,
    "m16ib_like.toml": (
        "p1",
        ToolPose((0.90, 0.30, 1.00), _ACROSS),
        ToolPose((1.15, -0.30, 0.85), _ACROSS),
    ),
}
"""Three poses of each arm. At p1 and p3 of the large robot the wrist allows less than 0.3 m/s; the
file of the last has one pose."""
UPDATES = 5
SLOWEST, FASTEST = 0.3, 1.0
"""[m/s]."""
WORST, MEDIAN = 0.5, 0.2
"""Of the path error at k = 0, after five updates."""


def drawn(seed: int, arm: str) -> tuple[Any, str, float]:
    """A task, its name, and the speed that its plan reaches [m/s]."""
    rng = np.random.default_rng([FIRST + seed, list(ARMS).index(arm)])
    place = seed % len(POSES)
    pose = ARMS[arm][place]
    robot = arm if arm == "large" else find_cell(str(ROBOTS / arm))
    for _ in range(_DRAWS):
        speed, acceleration = rng.uniform(SLOWEST, FASTEST), rng.uniform(6.0, 12.5)
        kind, size = rng.choice(("circle", "square", "strokes")), rng.uniform(0.08, 0.16)
        about = {"robot": robot, "pose": pose, "individual": FIRST + seed}
        about["across_tool"] = arm == "m16ib_like.toml"  # the plane of its paper
        task: Any
        if kind == "strokes":
            limits = PathLimits(acceleration=acceleration, jerk=400.0)
            task = Strokes(side=size, speed=speed, limits=limits, imu=ImuCfg(), **about)
        else:
            contour = Circle(0.5 * size) if kind == "circle" else square(size, 0.2 * size)
            limits = PathLimits(acceleration=acceleration)
            task = Cut(contour=contour, speed=speed, limits=limits, imu=ImuCfg(), **about)
        try:
            motion: Any = prepare(task, seed=FIRST + seed).motion
        except ValueError:  # out of reach
            continue
        planned = motion.cuts[0] if kind == "strokes" else motion
        reached = planned.reached_speed
        if reached >= SLOWEST:
            name = f"{kind} of {1e3 * size:.0f} mm, place {place + 1}, {acceleration:.1f} m/s^2"
            return task, name, float(reached)
    raise ValueError(f"no task of seed {seed} reaches {SLOWEST} m/s at place {place + 1} of {arm}")


def run(place: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, arm = place
    task, name, reached = drawn(seed, arm)
    of = Case(cut=task, seed=FIRST + seed)
    row = {"seed": seed, "arm": arm.split("_")[0], "task": name, "m/s": reached}
    try:
        learned = from_estimate(of, UPDATES, tally)
    except ImuError as refusal:
        _, learning = of.from_tool(UPDATES, BY_TRACKER)
        tracked = Learned(of, list(learning))
        left = dict.fromkeys(("before k = 5", "estimate k = 5"), np.nan)
        yield (
            row
            | {"k = 0": tracked.um[0]}
            | left
            | {"tracker k = 5": tracked.um[-1]}
            | {"_refused": str(refusal)}
        )
        return
    assert learned.output is not None
    known = learned.output.known
    more = known.parameters.process_noise / FRACTION
    before = np.nan  # refused
    if more <= np.exp(3.0 * SpringPrior().process_noise):
        band = pass_band(learned.output.experiment.turn_rate, known.plants.lowest_mode)
        measure = replace(COMPARED, law=ToolLaw(cutoff=band))
        before = Learned(of, list(of.from_tool(UPDATES, measure, known.parameters)[1])).um[-1]
    tracked = Learned(of, list(of.from_tool(UPDATES, BY_TRACKER, known.parameters)[1]))
    yield row | {
        "k = 0": learned.um[0],
        "before k = 5": before,
        "estimate k = 5": learned.um[-1],
        "tracker k = 5": tracked.um[-1],
        "_refused": "",
    }


def checks(rows: Rows) -> Iterator[Check]:
    first = rows["k = 0"]
    estimate, tracker, before = (
        rows[f"{by} k = 5"] / first for by in ("estimate", "tracker", "before")
    )
    refused = np.array([bool(text) for text in rows["_refused"]])
    learned, told = estimate[~refused], refused & (tracker <= WORST)
    was = f"before: {np.isnan(before).sum()} refused, worst {np.nanmax(before):.3f}, "
    worst = float(learned.max()) if learned.size else np.inf
    median = float(np.median(learned)) if learned.size else np.inf
    yield at_most("path error after five updates over k = 0: worst", worst, WORST, label=was)
    yield at_most("the same: median", median, MEDIAN)
    yield all_hold(f"none is refused that the tracker learns ({told.sum()} are)", ~told)


CLAIM = Claim(
    title="Fast, hard motion learned from the estimate: tool deviation RMS in µm",
    seeds=10,
    cases=crossed(ARMS),
    run=run,
    checks=checks,
    counted="learned cuts",
)
