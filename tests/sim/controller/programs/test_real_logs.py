"""The assumed interpolator against logs of a real ABB IRB6640, which the project may not contain.

Curve 1: 101 targets 10 mm apart, zone z10, five runs at each of three speeds, by encoders.
"""

import csv
import os
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree

from armside import kinematics
from armside.kinematics.robots import LARGE_ROBOT
from armside.sim.controller.programs.tool_path import Row

SETS = Path(os.environ.get("ARMSIDE_MEASUREMENTS") or ".") / "irb6640_logs"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?")


def commands():
    """Targets (101, 3) [m] and motor angles (101, 6) [rad], as the file has them."""
    with (SETS / "command.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    values = [[[float(x) for x in NUMBER.findall(cell)] for cell in row[2:4]] for row in rows]
    return 1e-3 * np.array([p for p, _ in values]), np.array([q for _, q in values])


def tool(phi, offset):
    T = kinematics.compile(LARGE_ROBOT).pose(np.ascontiguousarray(phi))
    return T[:, :3, 3] + T[:, :3, :3] @ offset


BOUNDS = [("75.0", 0.05, 0.6), ("103.125", 0.1, 0.8), ("150", 0.2, 1.2)]
"""Speed [mm/s]; median and worst deviation [mm]. Seen: 0.034, 0.077, 0.182 and 0.55, 0.68, 1.05,
the worst at the bend of 0.85 m: more than the 0.4 mm that were hoped for, and growing with speed,
as errors of the servo do. Its corners leave no trace: quintic and sharp ones are off by as much."""


@pytest.mark.skipif(not SETS.is_dir(), reason="ARMSIDE_MEASUREMENTS names no folder irb6640_logs")
@pytest.mark.parametrize(("speed", "median", "worst"), BOUNDS)
def test_the_mean_run_of_an_irb6640_follows_the_parabolas(speed, median, worst):
    """The tool is found by the targets, whose angles are given too; 0.4 mm are left of it."""
    targets, phi = commands()
    T = kinematics.compile(LARGE_ROBOT).pose(phi)
    left = (targets - T[:, :3, 3]).ravel()
    offset = np.linalg.lstsq(np.concatenate(T[:, :3, :3]), left, rcond=None)[0]
    placed = tool(phi, offset)
    row = Row(moves=tuple(range(len(placed))), targets=placed, zones=np.full(len(placed), 0.01))
    path = row.path(row.samples(5e-5))
    s = np.r_[0.0, np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()]
    tree, grid, runs = KDTree(path), np.linspace(0.02, s[-1] - 0.02, 2000), []
    for file in sorted(SETS.glob(f"run_*_v{speed}_z10.csv")):
        log = np.genfromtxt(file, delimiter=",", skip_header=1)
        seen = tool(np.radians(log[:, 2:8]), offset)
        away, foot = tree.query(seen)
        at, first = np.unique(s[foot[away < 5e-3]], return_index=True)
        near = seen[away < 5e-3][first]
        runs.append(np.stack([np.interp(grid, at, column) for column in near.T], axis=1))
    assert len(runs) == 5
    deviation = 1e3 * tree.query(np.mean(runs, axis=0))[0]
    assert np.median(deviation) < median
    assert deviation.max() < worst
