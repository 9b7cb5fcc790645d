"""Gear errors found by IMU, and what they change for learning from the estimate.

For each seed the gear error of that robot is found as `armside gears` does, from the IMU at its
tool in runs around p2; cuts with all gear effects are learned from the estimate without it and with
it, as `armside laser` learns: following the pose.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from armside.kinematics import Arm
from armside.kinematics.robot_file import GearTerm
from armside.sim.cell import LARGE_CELL
from armside.sim.gears import VIRTUAL, GearAnalysis, analyse_gears
from armside.sim.gears.virtual_run import RUNS, recorded
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.specification import Cut

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._estimates import case, from_estimate
from ._gear_errors import discrepancies
from ._learned import POSES

FIVE, TEN = 5, 10
AROUND = "p2"
"""Pose that the robot moves around while its gears are found."""
GOAL = 0.08
"""Of the first error, in the worst run."""
COLUMNS = {
    **{"seed": "seed", "pose": "pose"},
    "axes": "axes found of those above 10 µm",
    "amplitude": "amplitude off, worst",
    "phase": "phase off [rad], worst",
    "without_0": "k = 0",
    "without_5": "without: k = 5",
    "without_10": "k = 10",
    "with_0": "with: k = 0",
    "with_5": "k = 5",
    "with_10": "k = 10",
    "without": "k = 10 over k = 0 without: without",
    "with": "with",
}


def found(seed: int, runs: int = RUNS) -> GearAnalysis:
    """Gear error of the robot of a seed, by the IMU at its tool."""
    setup = Cut(pose=AROUND, imu=ImuCfg())
    recordings = [recorded(setup, seed, run) for run in range(runs)]
    arm = Arm(LARGE_CELL.robot, LARGE_CELL.limits)
    return analyse_gears(arm, recordings, replace(VIRTUAL, sensor="imu"))


def run(seed: int, tally: Tally) -> Iterator[Row]:
    done = found(seed)
    for pose in POSES:
        yield at(seed, pose, done, tally)


def at(seed: int, pose: str, done: GearAnalysis, tally: Tally, updates: int = TEN) -> Row:
    """One seed at one pose."""
    terms = [] if done.found is None else done.found.terms
    known = tuple(GearTerm(t.joint, t.order, t.amplitude, t.phase) for t in terms)
    cells, diverged, start = dict[str, float](), False, np.nan
    for name, gear_error in (("without", ()), ("with", known)):
        of = case(Cut(pose=pose, gear_error=gear_error), seed)
        learned = from_estimate(of, updates, tally)
        um = learned.um
        start = start if name == "with" else um[0]
        for k, value in ((0, um[0]), (FIVE, um[min(FIVE, updates)]), (TEN, um[-1])):
            cells[f"{name}_{k}"] = value
        cells[name] = um[-1] / start
        diverged = diverged or learned.diverged
    truth = case(Cut(pose=pose), seed).experiment().loaded.model.gear_error
    assert truth is not None
    return (
        _gears(discrepancies(done, truth))
        | cells
        | {**{"seed": seed, "pose": pose, "_diverged": diverged}}
    )


def _gears(gears: tuple) -> dict:
    """Cells of what is found of each gear that has an error."""
    off = {name: np.array([getattr(g, name) for g in gears]) for name in ("amplitude", "phase")}
    known = np.isfinite(off["amplitude"])
    worst = {name: float(np.abs(of[known]).max(initial=0.0)) if known.any() else np.nan
             for name, of in off.items()}  # fmt: skip
    every = {f"_{name}": np.nan_to_num(np.abs(of), nan=np.inf) for name, of in off.items()}
    return {"axes": f"{int(known.sum())} of {len(gears)}"} | worst | every


def checks(rows: Rows) -> Iterator[Check]:
    amplitude, phase = (rows.joined(name).max() for name in ("_amplitude", "_phase"))
    without, knowing = rows["without"], rows["with"]
    worst = f"worst {without.max():.3f} without, {knowing.max():.3f} with"
    median = f"median {np.median(without):.3f} without, {np.median(knowing):.3f} with"
    left = "all gear effects, left after ten updates over k = 0"
    for statement, value, bar in (
        (f"each axis above 10 µm is found within 20 % (worst {amplitude:.2f})", amplitude, 0.2),
        (f"and within 0.2 rad (worst {phase:.2f})", phase, 0.2),
        (
            f"{left}: the worst is less with the gear error ({worst})",
            *(knowing.max() / without.max(), 1.0),
        ),
        (
            f"{left}: the median is less with it ({median})",
            *(np.median(knowing) / np.median(without), 1.0),
        ),
        (f"{left}: at most {GOAL:g} with it (worst {knowing.max():.3f})", knowing.max(), GOAL),
    ):
        yield Check("", statement, "", float(value), high=bar)
    yield all_hold("no case diverges", ~rows["_diverged"])


CLAIM = Claim(
    title="Learning from an estimate that knows the gear error: tool deviation RMS in µm",
    seeds=10,
    run=run,
    checks=checks,
    columns=COLUMNS,
    counted="learned cuts",
)
