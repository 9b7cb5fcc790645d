"""What a robot cell is given to do in one episode, and the distributions it is drawn from.

| what | drawn from |
|---|---|
| pose | one of the cell's named poses, moved by up to 50 mm along each base axis, uniformly |
| speed | uniform in [20, 60] mm/s |
| payload | uniform in [0, 40] kg beside the tool's own mass; nothing on the IRB1400 |
| individual | friction of each axis and stiffness of each gear within +-10 % of nominal, uniform |

Ranges of payload and individual are an ESTIMATE of what a cell meets in a year.
"""

import copy
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from ..cell import CELLS, Cell
from ..cutting import CuttingPlant, plan
from ..experiment import CircleTask, Experiment
from ..individual import with_friction
from ..instruments.laser_tracker import LaserTrackerCfg, set_up
from ..model import AXES, RobotModel
from ..motion.poses import ToolPose, pose
from ..robot import VirtualRobot

POSE_SPREAD = 0.050
"""[m]"""
SPEEDS = (0.020, 0.060)
"""[m/s]"""
PAYLOADS = {"large": (0.0, 40.0), "irb1400": (0.0, 0.0)}
"""[kg], by robot."""
SPREAD = 0.10
"""Of friction and stiffness."""

TEST_SEEDS = range(900_000_000, 900_000_100)
"""Seeds of episodes that results are reported on. Training and search refuse them."""

OPTIONS = ("pose", "speed", "payload", "individual")


@dataclass(frozen=True, kw_only=True)
class Task:
    """One job of one robot individual."""

    pose: ToolPose
    speed: float
    """[m/s]"""
    payload: float
    """[kg], beside the tool's own mass. The controller is told."""
    individual: int
    """Seed of the robot individual, the tracker's set-up and all noise."""


def draw(robot: str, rng: np.random.Generator, options: Mapping[str, Any] | None = None) -> Task:
    """Draw a task; what `options` gives is taken instead.

    The draws do not depend on the options: fixing the speed leaves the pose of a seed.

    Args:
        options: any of `pose` (a name or a ToolPose), `speed` [m/s], `payload` [kg] and
            `individual` (a seed).

    Raises:
        ValueError: an option that does not exist or is out of range.
    """
    options = dict(options or {})
    unknown = [name for name in options if name not in OPTIONS]
    if unknown:
        raise ValueError(f"Unknown option {unknown[0]!r} of reset. Options: {', '.join(OPTIONS)}")
    cell = CELLS[robot]
    base = list(cell.poses.values())[rng.integers(len(cell.poses))]
    offset = rng.uniform(-POSE_SPREAD, POSE_SPREAD, 3)
    x, y, z = (np.array(base.position) + offset).tolist()
    drawn = {
        "pose": replace(base, position=(x, y, z)),
        "speed": float(rng.uniform(*SPEEDS)),
        "payload": float(rng.uniform(*PAYLOADS[robot])),
        "individual": int(rng.integers(2**31)),
    }
    return Task(**{name: _option(cell, name, options.get(name, drawn[name])) for name in OPTIONS})


def _option(cell: Cell, name: str, value: Any) -> Any:
    if name == "pose":
        if isinstance(value, str):
            return pose(value, cell.poses)
        if not isinstance(value, ToolPose):
            raise ValueError(f"pose must be a name or a ToolPose, got {value!r}")
        return value
    if name == "individual":
        if not isinstance(value, (int, np.integer)) or value < 0:
            raise ValueError(f"individual must be a seed, a whole number >= 0, got {value!r}")
        return int(value)
    low = 0.0 if name == "payload" else 1e-3
    if not isinstance(value, (int, float, np.number)) or not low <= value < np.inf:
        unit = "kg" if name == "payload" else "m/s"
        raise ValueError(f"{name} must be a number >= {low:g} {unit}, got {value!r}")
    return float(value)


def experiment(cell: Cell, nominal: RobotModel, task: Task, radius: float = 0.005) -> Experiment:
    """Build the robot individual, set up the tracker and load the motion.

    Raises:
        ValueError: the task leaves the joint limits or the reach.
    """
    individual, tracking, noise = (
        np.random.default_rng(s) for s in np.random.SeedSequence(task.individual).spawn(3)
    )
    circle = CircleTask(pose=task.pose, radius=radius, speed=task.speed)
    loaded = with_payload(nominal, task.payload)
    motion, reference = plan(cell, loaded, circle.path, task.pose.quaternion, task.speed)
    friction, stiffness = individual.uniform(1.0 - SPREAD, 1.0 + SPREAD, (2, len(AXES)))
    robot = with_friction(with_gear_stiffness(loaded, stiffness), friction)
    job = VirtualRobot(robot).load(reference)
    plant = CuttingPlant(job, set_up(LaserTrackerCfg(), tracking), noise)
    return Experiment(task=circle, motion=motion, job=job, plant=plant)


def with_payload(model: RobotModel, payload: float) -> RobotModel:
    """The robot with a payload [kg] added to its tool, spread as the tool's own mass is.

    Raises ValueError for a payload on a robot whose model has no body `tool`.
    """
    if payload == 0.0:
        return model
    mj = copy.copy(model.mj)
    body = mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_BODY, "tool")
    if body < 0:
        raise ValueError("this robot's model has no body `tool` that could carry a payload")
    factor = 1.0 + payload / mj.body_mass[body]
    mj.body_mass[body] *= factor
    mj.body_inertia[body] *= factor
    mujoco.mj_setConst(mj, mujoco.MjData(mj))
    return replace(model, mj=mj)


def with_gear_stiffness(model: RobotModel, factor: np.ndarray) -> RobotModel:
    """The robot with the spring of each gear scaled; its damping by the square root, so that the
    damping ratio stays. factor: (6,), > 0. A robot with rigid gears stays as it is."""
    mj = copy.copy(model.mj)
    if len(model.flex):
        joints = [mj.joint(f"flex_{i}").id for i in AXES]
        mj.jnt_stiffness[joints] *= factor
        mj.dof_damping[model.flex] *= np.sqrt(factor)
    return replace(model, mj=mj)
