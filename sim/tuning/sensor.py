"""Sensors that the reward is computed from: each measures the deviation of the tool.

A sensor is set up by the first run of an episode, the one without learning, and reads every run.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from typing import TYPE_CHECKING

from armside.kinematics import CompiledRobot
from armside.kinematics import compile as compile_robot

from ..cell import CELLS
from ..cut.tool_motion import ToolMotion
from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import ImuCfg
from ..laser.experiment import Experiment
from ..laser.plant import Pass

if TYPE_CHECKING:
    from ..laser.tool_path import ToolOutput

Reading = Callable[[Pass], ToolError]
Sensor = Callable[[Experiment, Pass], Reading]


class RewardSensor(Enum):
    """Sensor that the reward is computed from."""

    TRACKER = "tracker"
    """A laser tracker."""
    ESTIMATE = "estimate"
    """Motor angles and an IMU at the tool; the arm is identified from the first run of an episode,
    which takes seconds."""
    MOTOR = "motor"
    """The motor angles, by rigid forward kinematics."""

    def sensor(self, robot: str) -> Sensor:
        """The sensor of a robot. Raises ValueError for a robot that it cannot serve."""
        if self is RewardSensor.TRACKER:
            return _TrackerReading.set_up
        if self is RewardSensor.MOTOR:
            return _Motors(robot)
        if robot != "large":
            raise ValueError(
                f"reward 'estimate' needs an open chain: the large robot, got {robot!r}"
            )
        return _Estimate()

    @property
    def label(self) -> str:
        """Words for tables and axes, after a quantity: "by the tracker"."""
        return f"by the {self.value}{'s' if self is RewardSensor.MOTOR else ''}"

    @property
    def imu(self) -> ImuCfg | None:
        """Configuration of the IMU that the sensor needs at the tool; None without one."""
        return ImuCfg() if self is RewardSensor.ESTIMATE else None


@dataclass(frozen=True)
class _TrackerReading:
    motion: ToolMotion

    @classmethod
    def set_up(cls, experiment: Experiment, _first: Pass) -> Reading:
        return cls(experiment.motion)

    def __call__(self, cut: Pass) -> ToolError:
        return tool_error(self.motion, cut.tracker.time, cut.tracker.position)


@dataclass(frozen=True)
class _Motors:
    robot: str

    def __call__(self, experiment: Experiment, _first: Pass) -> Reading:
        return _MotorReading(self.robot, experiment.motion)


@dataclass(frozen=True)
class _MotorReading:
    robot: str
    motion: ToolMotion

    def __call__(self, cut: Pass) -> ToolError:
        arm, log = _arm(self.robot), cut.recording
        asked, got = (arm.pose(phi)[:, :3, 3] for phi in (log.reference, log.motor_angle))
        # r is shifted against the deflection that the controller expects: compare with r, not
        # with the programmed path.
        return tool_error(self.motion, log.time, self.motion.position + got - asked)


@lru_cache
def _arm(robot: str) -> CompiledRobot:
    return compile_robot(CELLS[robot].robot)


@dataclass(frozen=True)
class _Estimate:
    """The assumed payload is right; the springs are those of the nominal robot."""

    def __call__(self, experiment: Experiment, first: Pass) -> Reading:
        # Imported here: the other sensors do without the estimator.
        from ..estimation.commissioning import Commissioning, OnFault
        from ..laser.tool_path import ToolPath

        measure = ToolPath(stiffness_error=0.0, commissioning=Commissioning(on_fault=OnFault.GO_ON))
        arm = measure.assumed(experiment)
        return _EstimateReading(measure.commissioned(experiment, arm, first), experiment.motion)


@dataclass(frozen=True)
class _EstimateReading:
    output: "ToolOutput"
    motion: ToolMotion

    def __call__(self, cut: Pass) -> ToolError:
        moved = self.output(cut)[:, :3]
        return tool_error(self.motion, cut.recording.time, self.motion.position[0] + moved)
