"""Sensors that the reward is computed from: each measures the deviation of the tool.

A sensor is set up by the first run of an episode, the one without learning, and reads every run.
"""

from collections.abc import Callable
from enum import Enum
from functools import lru_cache, partial
from typing import TYPE_CHECKING

from armside import kinematics

from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import ImuCfg
from ..laser.experiment import Experiment, Pass
from ..motion.tool_motion import ToolMotion

if TYPE_CHECKING:
    from ..laser.tool_measure import ToolOutput

Reading = Callable[[Pass], ToolError]
Sensor = Callable[[Experiment, Pass], Reading]
_compiled = lru_cache(kinematics.compile)


class RewardSensor(Enum):
    """Sensor that the reward is computed from."""

    TRACKER = "tracker"
    """A laser tracker."""
    ESTIMATE = "estimate"
    """Motor angles and an IMU at the tool; the arm is identified from the first run of an episode,
    which takes seconds."""
    MOTOR = "motor"
    """The motor angles, by rigid forward kinematics."""

    @property
    def sensor(self) -> Sensor:
        """Set up by the first run of an episode."""
        if self is RewardSensor.TRACKER:
            return _by_tracker
        return _by_motors if self is RewardSensor.MOTOR else _by_estimate

    @property
    def label(self) -> str:
        """Words for tables and axes, after a quantity: "by the tracker"."""
        return f"by the {self.value}{'s' if self is RewardSensor.MOTOR else ''}"

    @property
    def imu(self) -> ImuCfg | None:
        """Configuration of the IMU that the sensor needs at the tool; None without one."""
        return ImuCfg() if self is RewardSensor.ESTIMATE else None


def _by_tracker(experiment: Experiment, _first: Pass) -> Reading:
    return partial(_tracker_error, experiment.motion)


def _tracker_error(motion: ToolMotion, cut: Pass) -> ToolError:
    return tool_error(motion, cut.tracker.time, cut.tracker.position)


def _by_motors(experiment: Experiment, _first: Pass) -> Reading:
    return partial(_motor_error, experiment.cut.cell.robot, experiment.motion)


def _motor_error(robot: kinematics.Robot, motion: ToolMotion, cut: Pass) -> ToolError:
    arm, log = _compiled(robot), cut.recording
    asked, got = (arm.pose(phi)[:, :3, 3] for phi in (log.reference, log.motor_angle))
    # r is shifted against the deflection that the controller expects: compare with r, not
    # with the programmed path.
    return tool_error(motion, log.time, motion.position + got - asked)


def _by_estimate(experiment: Experiment, first: Pass) -> Reading:
    """The assumed payload is right; the gears' springs are those of the nominal robot."""
    # Imported here: the other sensors do without the estimator.
    from ..estimation.commissioning import Commissioning, OnFault
    from ..laser.tool_measure import ToolPath

    measure = ToolPath(stiffness_error=0.0, commissioning=Commissioning(on_fault=OnFault.GO_ON))
    output = measure.commissioned(experiment, measure.assumed(experiment), first)
    return partial(_estimated_error, output, experiment.motion)


def _estimated_error(output: "ToolOutput", motion: ToolMotion, cut: Pass) -> ToolError:
    moved = output.estimated(cut).displacement[:, :3]
    return tool_error(motion, cut.recording.time, motion.position[0] + moved)
