"""What experiments on the arm side share: beliefs about a robot, cases, stored identifications."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic
from armside.sim.cell import LARGE_CELL, LARGE_ROBOT_POSES
from armside.sim.cut.task import CircleTask
from armside.sim.cut.timing import PathLimits
from armside.sim.estimation.arm_learning import ArmLearningCfg, Commissioned, Measure, begin
from armside.sim.estimation.arm_springs import Springs
from armside.sim.estimation.nominal import NominalArm, NominalCfg, nominal_arm
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import Experiment, Iteration, iterate, prepare
from armside.sim.records.summary import plain
from armside.sim.robot.effects import Effect
from armside.sim.robot.model import RobotModel, load_model
from armside.sim.robot.virtual_robot import LOG_PERIOD

from .shell.errors import InputError

_STREAM = 0xA2  # of the draw of beliefs, apart from those of individual and instruments


def believed_arm(robot: RobotModel, stiffness_error: float, seed: int, **known: Any) -> NominalArm:
    """The arm as its owner believes it to be: each gear's stiffness wrong, uniformly.

    Args:
        stiffness_error: relative, e.g. 0.3 for factors in 0.7 .. 1.3.
        known: further fields of `NominalCfg`.
    """
    rng = np.random.default_rng([seed, _STREAM])
    factors = 1.0 + rng.uniform(-stiffness_error, stiffness_error, 6)
    return nominal_arm(robot, NominalCfg(stiffness=tuple(factors), **known))


def stored_springs(folder: Path, place: Mapping[str, Any]) -> Springs:
    """Springs that `armside identify` has written.

    place: the options that say where, such as {"pose": "p1"}; springs act together by pose.

    Raises:
        InputError: there are none, they are not whole, or were identified at another place.
    """
    file = folder / "summary.json"
    try:
        stored = json.loads(file.read_text(encoding="utf-8"))
        springs = stored["springs"]
        known_at = {name: stored["config"].get(name) for name in place}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{folder} holds no identification of armside identify") from error
    if known_at != plain(place):
        said = ", ".join(f"{name} {value}" for name, value in known_at.items() if value)
        raise InputError(f"{folder} was identified at {said}: springs act together by pose")
    return _springs(springs, file)


_SHAPES: Mapping[str, tuple[int, ...]] = {
    "stiffness": (6, 6),
    "damping": (6,),
    "clock_offset": (),
    "distrust": (),
    "mounting": (3,),
}
"""Of each entry of `Springs`."""


def _springs(stored: Any, file: Path) -> Springs:
    """Raises InputError for what is missing, or is no array of numbers of its shape."""
    missing = [name for name in _SHAPES if name not in stored]
    if missing:
        raise InputError(f"{file}: springs lack {', '.join(missing)}; identify again")
    found = {}
    for name, shape in _SHAPES.items():
        try:
            value = np.array(stored[name], dtype=np.float64)
        except (ValueError, TypeError):
            value = np.array(np.nan)
        if value.shape != shape or not np.isfinite(value).all():
            raise InputError(f"{file}: springs.{name} must be numbers of shape {shape}")
        found[name] = value
    return Springs(
        stiffness=found["stiffness"],
        damping=found["damping"],
        clock_offset=float(found["clock_offset"]),
        distrust=float(found["distrust"]),
        mounting=found["mounting"],
    )


GEAR_EFFECTS = tuple(Effect)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One task on one individual of the large robot, with one belief of it."""

    pose: str = "p1"
    seed: int = 0
    speed: float = 0.040
    """Programmed [m/s]."""
    acceleration: float = 1.3
    """Limit of the controller along and across the path [m/s^2]."""
    without: tuple[Effect, ...] = ()
    """Effects of gears and drives that this individual lacks."""
    stiffness_error: float = 0.3
    believed: dict[str, Any] = field(default_factory=dict)
    """Further errors of the belief: fields of `NominalCfg`."""
    imu: ImuCfg = field(default_factory=ImuCfg)
    """The unit at the tool; its data sheet is known."""

    def experiment(self) -> Experiment:
        """The individual, at its place, with an IMU and under a tracker."""
        task = CircleTask(
            pose=LARGE_ROBOT_POSES[self.pose],
            speed=self.speed,
            limits=PathLimits(acceleration=self.acceleration),
        )
        return prepare(
            LARGE_CELL,
            load_model(LARGE_CELL.xml),
            task,
            seed=self.seed,
            without=self.without,
            imu=self.imu,
        )

    def arm(self) -> NominalArm:
        """What is believed of it."""
        return believed_arm(
            load_model(LARGE_CELL.xml), self.stiffness_error, self.seed, **self.believed
        )

    def on_arm_side(
        self, cfg: ArmLearningCfg, iterations: int, springs: Springs | None = None
    ) -> tuple[Commissioned, Iterator[Iteration]]:
        """Learn from the tool."""
        robot = load_model(LARGE_CELL.xml)
        return begin(self.experiment(), robot, self.arm(), self.imu, cfg, iterations, springs)

    def on_motor_side(self, iterations: int) -> Iterator[Iteration]:
        """Learn from the motors, as the thesis does."""
        law = Heuristic(Q=ZeroPhaseButterworth(10.0, LOG_PERIOD), gamma=0.9, delta=3)
        return iterate(self.experiment(), law, iterations)

    def compared(
        self, iterations: int, cfg: ArmLearningCfg | None = None
    ) -> dict[str, list[Iteration]]:
        """The same case learned from each measure; one identification serves all laws."""
        cfg = cfg or ArmLearningCfg()
        known, estimated = self.on_arm_side(cfg, iterations)
        found = {"motor": list(self.on_motor_side(iterations)), "estimate": list(estimated)}
        for measure in (Measure.TRACKER, Measure.TRUTH):
            name = "oracle" if measure is Measure.TRUTH else measure.value
            chosen = replace(cfg, measure=measure)
            found[name] = list(self.on_arm_side(chosen, iterations, known.springs)[1])
        return found


def rms(iterations: list[Iteration]) -> list[float]:
    """Arm RMS (9.6) of each iteration, from tracker samples [m]."""
    return [iteration.arm.rms for iteration in iterations]
