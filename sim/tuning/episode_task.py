"""Task of an episode, and the distributions it is drawn from.

| what | drawn from |
|---|---|
| pose | a named pose of the cell, moved along each base axis by up to 50 mm; v1: 250; uniformly |
| speed | uniform in [20, 60] mm/s; v1: in [20, 100], its logarithm uniform |
| payload | of the large robot, uniform in [20, 80] kg; v1: [0, 120]. Others keep their own tool |
| individual | friction, stiffness, ripple and geometry of one robot: `sim.robot.spread.Spread()` |
| shape, radius | a circle of 5 mm; v1: of 2 to 12 mm, its logarithm uniform; or as made: `Shapes` |

What moves the best design is turns per second, speed over 2 pi radius, from 0.3 to 8 Hz in v1:
below 1 Hz it lets pass 4 Hz, from 2 Hz on 2.5 Hz or less. Payload and individual hardly matter.
A robot of a file, or any in v1, may not reach beside its poses. A file's draws stay in the
directions in which its tool can move; offsets are halved until the contour can be cut.
A given individual may be of the production line, `sim.robot.spread.Drawn(N)`, or any `Individual`.
The ranges are an ESTIMATE of what a cell meets in a year. The controller knows the payload,
and nothing of the individual.
"""

import operator
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from armside import kinematics
from armside.arrays import Array

from ..cell import CELLS, Cell, ToolPose, pose
from ..instruments.imu import ImuCfg
from ..laser.experiment import Experiment, prepare
from ..laser.specification import Cut
from ..motion.contour import RADII, contour_of
from ..robot import spread
from ..robot.individual import Individual
from ..robot.model import RobotModel
from ..robot.spread import Drawn

SMALLEST, LARGEST = 0.001, 0.1
"""[m], of a radius that may be asked for."""


@dataclass(frozen=True)
class Shapes:
    """Shapes of an env and their radius, as `armside.sim.motion.contour.contour_of` has it."""

    names: tuple[str, ...] = ("circle",)
    radius: tuple[float, float] | None = None
    """Smallest and largest [m]; that of each shape's default if None."""
    logarithmic: bool = False
    """Of the radius its logarithm is drawn uniformly."""

    @property
    def are_drawn(self) -> bool:
        """Contours differ between episodes."""
        low, high = self.radius or (0.0, 0.0)
        return len(self.names) > 1 or low < high

    def draw(self, rng: np.random.Generator) -> tuple[str, float | None]:
        """Shape and radius [m], None for the shape's default; draws nothing that is fixed."""
        name = self.names[0 if len(self.names) == 1 else int(rng.integers(len(self.names)))]
        if self.radius is None:
            return name, None
        low, high = self.radius
        return name, low if low == high else _uniform(rng, low, high, self.logarithmic)


def _uniform(rng: np.random.Generator, low: float, high: float, logarithmic: bool) -> float:
    if not logarithmic:
        return float(rng.uniform(low, high))
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def shapes_of(shape: Any, radius: Any) -> Shapes:
    """Shapes of one name or several, and a radius [m] or a range of it. Raises ValueError."""
    several = isinstance(shape, Sequence) and not isinstance(shape, str)
    names = tuple(check_shape(name) for name in (shape if several else (shape,)))
    if not names or len(set(names)) < len(names):
        raise ValueError(f"shape must be one or several different ones, got {shape!r}")
    if radius is None:
        return Shapes(names)
    ends = tuple(radius) if isinstance(radius, Sequence | np.ndarray) else (radius, radius)
    if len(ends) != 2:
        raise ValueError(f"radius must be a number or a range of two, got {radius!r}")
    low, high = (check_radius(end) for end in ends)
    if low > high:
        raise ValueError(f"radius must be a range from low to high, got {radius!r}")
    return Shapes(names, (low, high))


def check_shape(value: Any) -> str:
    """A known shape. Raises ValueError for any other."""
    if not isinstance(value, str) or value not in RADII:
        raise ValueError(f"Unknown shape {value!r}. It can be: {', '.join(RADII)}")
    return value


def check_radius(value: Any) -> float:
    """A radius [m]. Raises ValueError for what is no number in range."""
    return _number("radius", value, SMALLEST, LARGEST, f"from {SMALLEST:g} to {LARGEST:g} m")


def _number(name: str, value: Any, low: float, high: float, limits: str) -> float:
    numbers = int | float | np.integer | np.floating
    number = isinstance(value, numbers) and not isinstance(value, bool)
    if not (number and low <= value <= high):
        raise ValueError(f"{name} must be a number {limits}, got {value!r}")
    return float(value)


FRACTIONS = (1.0, 0.5, 0.25, 0.125, 0.0)
"""Of the offset, in the order in which they are tried."""
IMMOVABLE = 1e-6
"""Singular values of the Jacobian below this part of the largest are directions without motion."""


def candidates(cell: Cell, near: ToolPose, drawn: ToolPose) -> Iterator[ToolPose]:
    """The drawn pose, moved ever closer to the named one, which comes last. Where orientation is
    free, an arm in a plane stays in it."""
    base = np.array(near.position)
    offset = np.array(drawn.position) - base
    if cell.free_rotation:
        offset = movable(cell, near) @ offset
    for fraction in FRACTIONS:
        x, y, z = (base + fraction * offset).tolist()
        yield replace(near, position=(x, y, z))


def movable(cell: Cell, pose: ToolPose) -> Array:
    """Projection (3, 3) on the directions in which the tool moves at a pose."""
    start = np.zeros(cell.robot.n_joints) if cell.home is None else np.array(cell.home)
    target = np.array([pose.position])
    phi = kinematics.inverse_numeric_path(cell.robot, target, start, limits=cell.limits)[0]
    U, size, _ = np.linalg.svd(kinematics.compile(cell.robot).jacobian(phi)[:3])
    moved = U[:, : len(size)][:, size > IMMOVABLE * size[0]]
    return moved @ moved.T


POSE_SPREAD = 0.050  # [m]
SPEEDS = (0.020, 0.060)
"""[m/s]"""
SLOWEST, FASTEST = 0.001, 0.1
"""[m/s], that may be asked for: thesis 9.3.1 goes no further than 100 mm/s."""
PAYLOADS: Mapping[str, tuple[float, float]] = {"large": (20.0, 80.0)}
"""[kg], by robot; a robot that is not here keeps the tool of its model."""


class Ranges(NamedTuple):
    """Speeds [m/s], payloads [kg], radii [m] of circles and offsets [m] of poses that one version
    of the env draws; of speeds and radii the logarithm where that is said."""

    speeds: tuple[float, float]
    payloads: Mapping[str, tuple[float, float]]
    radius: tuple[float, float] | None
    place: float = POSE_SPREAD
    logarithmic: bool = False


RANGES = (
    Ranges(SPEEDS, PAYLOADS, None),
    Ranges((0.020, 0.100), {"large": (0.0, 120.0)}, (0.002, 0.012), 0.250, True),
)
"""By version. ESTIMATE: of version 1, as wide as to make the best design differ between tasks."""
TEST_SEEDS = range(900_000_000, 900_000_100)
"""Seeds of episodes that results are reported on. Training and search refuse them."""

OPTIONS = ("pose", "speed", "payload", "individual", "shape", "radius")


@dataclass(frozen=True, kw_only=True)
class Task:
    """One job of one robot individual."""

    pose: ToolPose
    speed: float
    """[m/s]"""
    payload: float | None
    """Mass of the tool [kg]; None for the one of the model."""
    individual: int | Drawn | Individual
    """The robot individual, or its seed."""
    seed: int
    """Of the tracker's set-up and all noise; the individual's where that is a seed."""
    shape: str = "circle"
    radius: float = RADII["circle"]
    """[m], as `armside.sim.motion.contour.contour_of` has it."""
    near: ToolPose | None = None
    """Named pose that the tool was moved from; it may be moved less. None: it may not."""


def draw(
    robot: str | Cell,
    rng: np.random.Generator,
    options: Mapping[str, Any] | None = None,
    shapes: Shapes = Shapes(),
    ranges: Ranges = RANGES[0],
) -> Task:
    """Draw a task for a cell, or that of a name; what `options` gives is taken instead, and leaves
    the other draws of a seed. Raises ValueError for options as `IlcTuningEnv.reset`."""
    if not isinstance(options, Mapping | None):
        raise ValueError(f"options of reset must be a dict, got {options!r}")
    options = dict(options or {})
    unknown = [name for name in options if name not in OPTIONS]
    if unknown:
        raise ValueError(f"Unknown option {unknown[0]!r} of reset. Options: {', '.join(OPTIONS)}")
    named = not isinstance(robot, Cell)
    cell, masses = (CELLS[robot], ranges.payloads.get(robot)) if named else (robot, None)
    base = list(cell.poses.values())[rng.integers(len(cell.poses))]
    offset = rng.uniform(-ranges.place, ranges.place, 3)
    x, y, z = (np.array(base.position) + offset).tolist()
    payload = float(rng.uniform(*(masses or (0.0, 1.0))))
    drawn = {
        "pose": replace(base, position=(x, y, z)),
        "speed": _uniform(rng, *ranges.speeds, ranges.logarithmic),
        "payload": payload if masses else None,
        "individual": int(rng.integers(2**31)),
    }
    # Whatever came later is drawn later: earlier tasks stay as they were.
    shape, radius = shapes.draw(rng)
    drawn |= {"shape": shape, "radius": radius}
    if radius is None:
        drawn["radius"] = RADII[check_shape(options.get("shape", shape))]
    taken = {name: _option(cell, name, options.get(name, drawn[name])) for name in OPTIONS}
    robot_or_seed = taken["individual"]
    seed = robot_or_seed if isinstance(robot_or_seed, int) else drawn["individual"]
    far = not named or ranges.place > POSE_SPREAD
    near = base if far and "pose" not in options else None
    return Task(**taken, seed=seed, near=near)


def _option(cell: Cell, name: str, value: Any) -> Any:
    if name == "pose":
        if isinstance(value, str):
            return pose(value, cell.poses)
        if not isinstance(value, ToolPose):
            raise ValueError(f"pose must be a name or a ToolPose, got {value!r}")
        return value
    if name == "shape":
        return check_shape(value)
    if name == "radius":
        return check_radius(value)
    if name == "individual":
        return value if isinstance(value, Drawn | Individual) else whole("individual", value, 0)
    if name == "payload":
        largest = np.finfo(float).max
        return None if value is None else _number(name, value, 0.0, largest, ">= 0 kg")
    return _number(name, value, SLOWEST, FASTEST, f"from {SLOWEST:g} to {FASTEST:g} m/s")


def experiment(
    robot: str | Cell, nominal: RobotModel, task: Task, imu: ImuCfg | None = None
) -> Experiment:
    """A task's contour, cut by one individual, with that IMU at the tool. Raises ValueError as
    `prepare`: joint limits, reach, load, parameters that the robot lacks."""
    individual = task.individual
    if isinstance(individual, int):
        # A stream apart from those that `prepare` spawns.
        individual = spread.draw(np.random.default_rng([individual, 1]), nominal)
    base = Cut(robot=robot, radius=task.radius, individual=individual, imu=imu)
    contour = None if task.shape == "circle" else contour_of(task.shape, task.radius)
    cut = replace(base, pose=task.pose, speed=task.speed, payload=task.payload, contour=contour)
    return prepare(cut, seed=task.seed, nominal=nominal)


def within_reach(
    robot: str | Cell, nominal: RobotModel, task: Task, imu: ImuCfg | None = None
) -> tuple[Task, Experiment]:
    """A task and its experiment, moved less far from its named pose where that is out of reach.
    Raises as `experiment`, for the named pose itself."""
    if task.near is None:
        return task, experiment(robot, nominal, task, imu)
    cell = robot if isinstance(robot, Cell) else CELLS[robot]
    *others, last = (replace(task, pose=p) for p in candidates(cell, task.near, task.pose))
    for moved in others:
        try:
            return moved, experiment(robot, nominal, moved, imu)
        except ValueError:
            continue
    return last, experiment(robot, nominal, last, imu)


def whole(name: str, value: Any, low: int, high: int | None = None) -> int:
    """A whole number from `low` to `high`, of Python or NumPy; True and False are none."""
    try:
        number = None if isinstance(value, bool | np.bool_) else operator.index(value)
    except TypeError:
        number = None
    if number is None or number < low or (high is not None and number > high):
        limits = f">= {low}" if high is None else f"in {low} .. {high}"
        raise ValueError(f"{name} must be a whole number {limits}, got {value!r}")
    return number
