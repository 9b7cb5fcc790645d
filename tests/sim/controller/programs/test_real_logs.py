"""The assumed interpolator against logs of a real ABB IRB6640, which the project may not contain.

Curve 1: 101 targets 10 mm apart, zone z10, five runs at each of three speeds, by encoders.
"""

import csv
import os
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d
from scipy.spatial import KDTree

from armside import kinematics
from armside.kinematics.robots import LARGE_ROBOT
from armside.sim.controller.programs.tool_path import Row, arc_lengths

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
the worst at the bend of 0.85 m: more than the 0.4 mm that were hoped for, and at every speed. Its
corners leave no trace: quintic and sharp ones are off by as much."""
needs_logs = pytest.mark.skipif(
    not SETS.is_dir(), reason="ARMSIDE_MEASUREMENTS names no folder irb6640_logs"
)


class Curve:
    """Curve 1: the path of the parabolas for its targets, and where runs are.

    The tool is found by the targets, whose angles are given too; 0.4 mm are left of it.
    """

    def __init__(self):
        targets, self.phi = commands()
        T = kinematics.compile(LARGE_ROBOT).pose(self.phi)
        left = (targets - T[:, :3, 3]).ravel()
        self.offset = np.linalg.lstsq(np.concatenate(T[:, :3, :3]), left, rcond=None)[0]
        placed, n = tool(self.phi, self.offset), len(targets)
        row = Row(moves=tuple(range(n)), targets=placed, zones=np.full(n, 0.01))
        self.path = row.path(row.samples(5e-5))
        self.s, self.polygon = arc_lengths(self.path), arc_lengths(placed)
        self.tree = KDTree(self.path)

    def deviation(self, speed):
        """Of the mean run (2000, 3) [m], and the places nearest to it."""
        grid, runs = np.linspace(0.02, self.s[-1] - 0.02, 2000), []
        for file in sorted(SETS.glob(f"run_*_v{speed}_z10.csv")):
            log = np.genfromtxt(file, delimiter=",", skip_header=1)
            seen = tool(np.radians(log[:, 2:8]), self.offset)
            away, foot = self.tree.query(seen)
            at, first = np.unique(self.s[foot[away < 5e-3]], return_index=True)
            near = seen[away < 5e-3][first]
            runs.append(np.stack([np.interp(grid, at, column) for column in near.T], axis=1))
        assert len(runs) == 5
        foot = self.tree.query(np.mean(runs, axis=0))[1]
        return np.mean(runs, axis=0) - self.path[foot], foot

    def by_acceleration(self, speed, foot):
        """(N * 3, 6): tool, across the path, for each joint's acceleration [m s^2]."""
        knots = self.polygon * self.s[-1] / self.polygon[-1]
        spline, at, h = CubicSpline(knots, self.phi), self.s[foot], 1e-6
        q = spline(at)
        ahead = [tool(q + h * e, self.offset) - tool(q, self.offset) for e in np.eye(6)]
        found = np.stack(ahead, axis=2) / h * uniform_filter1d(spline(at, 2), 60, axis=0)[:, None]
        tangent = np.gradient(self.path, axis=0)[foot]
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        along = np.einsum("ni,nij->nj", tangent, found)
        across = found - tangent[:, :, None] * along[:, None]
        return (1e-3 * float(speed)) ** 2 * across.reshape(-1, 6)


@needs_logs
@pytest.mark.parametrize(("speed", "median", "worst"), BOUNDS)
def test_the_mean_run_of_an_irb6640_follows_the_parabolas(speed, median, worst):
    deviation = 1e3 * np.linalg.norm(Curve().deviation(speed)[0], axis=1)
    assert np.median(deviation) < median
    assert deviation.max() < worst


@needs_logs
def test_a_third_of_the_deviation_of_fast_runs_is_a_lag_of_the_joints():
    """In proportion to their accelerations, by factors of the runs at 103 mm/s; seen: a half."""
    curve = Curve()
    slow, foot = curve.deviation("103.125")
    factors = np.linalg.lstsq(curve.by_acceleration("103.125", foot), slow.ravel(), rcond=None)[0]
    fast, foot = curve.deviation("150")
    left = fast - (curve.by_acceleration("150", foot) @ factors).reshape(-1, 3)
    before, after = (np.median(np.linalg.norm(each, axis=1)) for each in (fast, left))
    assert after < 0.67 * before
    assert (factors > 0.0).all()
