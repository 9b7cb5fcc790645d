"""Tasks and robot individuals of the claims about first cuts.

Settings were chosen on the individuals and tasks of development. Those that judge are drawn by
another seed, and both lists stand here.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from armside.sim.cell import TOOL_QUATERNION, ToolPose
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.motion.contour import Circle, ClosedCurve, hexagon, slot, square
from armside.sim.motion.timing import PathLimits
from armside.sim.part.contour_file import read_contour

DEVELOPMENT = tuple(range(1001, 1013))
"""Individuals on which settings were chosen, with tasks of the seed 77."""
JUDGED = (506, 31, 192, 804, 321, 478)
"""Individuals that judge: the first three without and the first three with hidden hinges among
numbers below 1000, in the order of `numpy.random.default_rng(20261205).permutation(1000)`."""
JUDGED_BY_IMU = (525, 844, 275, 240, 269, 367)
"""Individuals that judge twins by an IMU: those after `JUDGED`, which did so before the interval of
such twins was fitted."""
JUDGED_BY_SCAN = (59, 635, 754, 976, 292, 554, 462, 21, 912, 508)
"""Individuals that judge what a scan gives: the first ten of that permutation that judged nothing
before."""
JUDGED_SEED, GUARD_SEED, DEVELOPMENT_SEED = 20261205, 20261206, 77
SEEN = (909, 940, 874, 841, 129, 177)
"""Individuals that judged before the prediction was fitted anew, and judge no longer."""

SHAPES: dict[str, Callable[[float], ClosedCurve]] = {
    "circle": lambda size: Circle(0.5 * size),
    "square": lambda size: square(size, 0.15 * size),
    "hexagon": lambda size: hexagon(size, 0.15 * size),
    "slot": lambda size: slot(size, size / 3.0),
}
FILE = "file"
"""A contour read from a file."""
_HOUSE = """corner = 3.0
points = [[-15, -12], [15, -12], [15, 6], [0, 16], [-15, 6]]
"""
"""[mm], as a contour file has it."""


def tasks(count: int, seed: int) -> list[tuple[str, Cut]]:
    """Kind and cut: poses over the workspace with turned tools, 6 to 80 mm wide, 20 to 100 mm/s."""
    rng = np.random.default_rng(seed)
    found = list[tuple[str, Cut]]()
    while len(found) < count:
        place = rng.uniform((1.2, -0.8, 1.0), (2.3, 0.8, 2.0))
        turned = Rotation.from_quat(TOOL_QUATERNION, scalar_first=True) * Rotation.from_rotvec(
            rng.uniform(-0.5, 0.5, 3)
        )
        kind = str(rng.choice((*SHAPES, FILE)))
        size = float(np.exp(rng.uniform(np.log(0.006), np.log(0.080))))
        speed = float(rng.uniform(0.02, 0.10))
        pose = ToolPose(_triple(place), _quaternion(turned))
        cut = Cut(pose=pose, contour=_contour(kind, size), speed=speed)
        if _can_be_made(cut):
            found.append((kind, cut))
    return found


def tasks_beyond(count: int, seed: int) -> list[Cut]:
    """Cuts beyond what a twin was commissioned with: faster, smaller, farther, heavier.

    So far that drives reach their limits and gears do not leave their lost motion: where a twin is
    only a little off its range, nothing ends badly and a guard has nothing to find.
    """
    rng = np.random.default_rng(seed)
    found = list[Cut]()
    while len(found) < count:
        ((_, cut),) = tasks(1, int(rng.integers(2**31)))
        more = rng.random(4) < 0.4
        if more[0]:
            limits = PathLimits(acceleration=float(rng.uniform(2.0, 16.0)))
            cut = replace(cut, speed=float(rng.uniform(0.1, 0.7)), limits=limits)
        if more[1]:
            radius = float(np.exp(rng.uniform(np.log(2e-4), np.log(3e-3))))
            cut = replace(
                cut, contour=Circle(radius), speed=float(rng.uniform(0.1, 1.0) * cut.speed)
            )
        if more[2]:
            place = rng.uniform((0.8, -1.6, 0.3), (2.7, 1.6, 2.5))
            cut = replace(cut, pose=ToolPose(_triple(place), cut.tool_pose.quaternion))
        if more[3]:
            cut = replace(cut, payload=float(rng.uniform(1.0, 250.0)))
        if more.any() and _can_be_made(cut):
            found.append(cut)
    return found


def _contour(kind: str, size: float) -> ClosedCurve:
    if kind == FILE:
        return house()
    return SHAPES[kind](size)


def house() -> ClosedCurve:
    """The contour of a house's front, as its file has it."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        file = Path(folder) / "house.toml"
        file.write_text(_HOUSE, encoding="utf-8")
        return read_contour(file)


def _can_be_made(cut: Cut) -> bool:
    try:
        prepare(cut)
    except ValueError:
        return False
    return True


def _triple(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _quaternion(turned: Rotation) -> tuple[float, float, float, float]:
    w, x, y, z = (float(value) for value in turned.as_quat(scalar_first=True))
    return w, x, y, z
