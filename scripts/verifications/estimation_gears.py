"""The claims of `armside verify estimation-gears`: gear errors found by IMU, and what they change.

For each seed `armside gears` finds the gear error of that robot from the IMU at its tool, in runs
around p2; cuts with all gear effects are learned from the estimate without it and with it, as
`armside laser` learns: following the pose.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from armside.kinematics import Arm
from armside.kinematics.robot_file import GearTerm
from armside.sim.cell import LARGE_CELL
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.gears import VIRTUAL, GearAnalysis, analyse
from armside.sim.gears.found import Discrepancy, discrepancies
from armside.sim.gears.virtual_run import RUNS, recorded
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import COMPARED, Case, rms
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.laser.way_measure import PathAlongWay
from armside.sim.notes import Tally

from ..jobs.workers import Workers

POSES = ("p1", "p2", "p3")
FIVE, TEN = 5, 10
MEASURE = PathAlongWay(law=COMPARED.law)
AROUND = "p2"
"""Pose that the robot moves around while its gears are found."""
GOAL = 0.08
"""Of the first error, in the worst run."""
COLUMNS = (
    *("seed", "pose", "axes found of those above 10 µm", "amplitude off, worst"),
    *("phase off [rad], worst", "k = 0", "without: k = 5", "k = 10"),
    *("with: k = 0", "k = 5", "k = 10", "k = 10 over k = 0 without: without", "with"),
)


class Learned(NamedTuple):
    """Deviation of the tool [m] before learning, after five and after ten updates."""

    start: float
    five: float
    ten: float


class Row(NamedTuple):
    """One seed at one pose."""

    seed: int
    pose: str
    gears: tuple[Discrepancy, ...]
    without: Learned
    knowing: Learned
    """With the gear error that was found."""
    diverged: bool

    @property
    def ratios(self) -> tuple[float, float]:
        """Left after ten updates, without and with, over the first error without."""
        return self.without.ten / self.without.start, self.knowing.ten / self.without.start


def estimation_gears(seeds: Iterable[int]) -> Table:
    """Every case of every seed at every pose."""
    with Workers() as workers:
        by_seed = list(workers.map(_rows, list(seeds)))
    said, rows = Tally(), list[Row]()
    for of_seed, tally in by_seed:
        rows += of_seed
        said.include(tally)
    return Table(
        "Learning from an estimate that knows the gear error: tool deviation RMS in µm",
        COLUMNS,
        [_cells(row) for row in rows],
        verdicts(rows),
        said.notes("learned cuts"),
    )


def found(seed: int, runs: int = RUNS) -> GearAnalysis:
    """Gear error of the robot of a seed, by the IMU at its tool."""
    setup = Cut(pose=AROUND, imu=ImuCfg())
    recordings = [recorded(setup, seed, run) for run in range(runs)]
    arm = Arm(LARGE_CELL.robot, LARGE_CELL.limits)
    return analyse(arm, recordings, replace(VIRTUAL, sensor="imu"))


def _rows(seed: int) -> tuple[list[Row], Tally]:
    said = Tally()
    done = found(seed)
    return [row(seed, pose, done, said) for pose in POSES], said


def row(seed: int, pose: str, done: GearAnalysis, said: Tally, updates: int = TEN) -> Row:
    """One seed at one pose; notes of the cuts that are learned are counted."""
    found_terms = [] if done.found is None else done.found.terms
    terms = tuple(GearTerm(t.joint, t.order, t.amplitude, t.phase) for t in found_terms)
    cut = Cut(pose=pose, imu=ImuCfg())
    learned, diverged = list[Learned](), False
    for known in ((), terms):
        case = Case(cut=replace(cut, gear_error=known), seed=seed)
        runs = list(case.from_tool(updates, MEASURE)[1])
        said.add(notes(case.experiment(), runs))
        lengths = rms(runs)
        learned.append(Learned(lengths[0], lengths[min(FIVE, updates)], lengths[-1]))
        diverged = diverged or runs[-1].diverged
    truth = Case(cut=cut, seed=seed).experiment().loaded.model.gear_error
    assert truth is not None
    without, knowing = learned
    return Row(seed, pose, discrepancies(done, truth), without, knowing, diverged)


def _cells(row: Row) -> tuple[int | str | float, ...]:
    known = [gear for gear in row.gears if np.isfinite(gear.amplitude)]
    amplitude = max((abs(gear.amplitude) for gear in known), default=np.nan)
    phase = max((abs(gear.phase) for gear in known), default=np.nan)
    axes = f"{len(known)} of {len(row.gears)}"
    um = [1e6 * length for length in (*row.without, *row.knowing)]
    return row.seed, row.pose, axes, amplitude, phase, *um, *row.ratios


def verdicts(rows: list[Row]) -> list[Check]:
    """The checks of all rows."""
    gears = [gear for row in rows for gear in row.gears]
    amplitude, phase = (
        np.nan_to_num(np.abs([getattr(gear, name) for gear in gears]), nan=np.inf)
        for name in ("amplitude", "phase")
    )
    without, knowing = np.array([row.ratios for row in rows]).T
    worst = f"worst {without.max():.3f} without, {knowing.max():.3f} with"
    median = f"median {np.median(without):.3f} without, {np.median(knowing):.3f} with"
    left = "all gear effects, left after ten updates over k = 0"
    return [
        Check("", f"each axis above 10 µm is found within 20 % (worst {amplitude.max():.2f})", "",
              amplitude.max(), high=0.2),
        Check("", f"and within 0.2 rad (worst {phase.max():.2f})", "", phase.max(), high=0.2),
        Check("", f"{left}: the worst is less with the gear error ({worst})", "",
              knowing.max() / without.max(), high=1.0),
        Check("", f"{left}: the median is less with it ({median})", "",
              float(np.median(knowing) / np.median(without)), high=1.0),
        Check("", f"{left}: at most {GOAL:g} with it (worst {knowing.max():.3f})", "",
              knowing.max(), high=GOAL),
        all_hold("no case diverges", [not row.diverged for row in rows]),
    ]  # fmt: skip
