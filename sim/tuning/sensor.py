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
from ..evaluation.tool_error import ArmSide, arm_side
from ..instruments.imu import ImuCfg
from ..laser.experiment import Experiment
from ..laser.plant import Pass
from ..robot.model import RobotModel, load_model

if TYPE_CHECKING:
    from ..estimation.arm_learning import ArmLearningCfg, Commissioned

Reading = Callable[[Pass], ArmSide]
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
        return _Estimate(robot)

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

    def __call__(self, cut: Pass) -> ArmSide:
        return arm_side(self.motion, cut.tracker.time, cut.tracker.position)


@dataclass(frozen=True)
class _Motors:
    robot: str

    def __call__(self, experiment: Experiment, _first: Pass) -> Reading:
        return _MotorReading(self.robot, experiment.motion)


@dataclass(frozen=True)
class _MotorReading:
    robot: str
    motion: ToolMotion

    def __call__(self, cut: Pass) -> ArmSide:
        arm, log = _arm(self.robot), cut.recording
        asked, got = (arm.pose(phi)[:, :3, 3] for phi in (log.reference, log.motor_angle))
        # r is shifted against the deflection that the controller expects: compare with r, not
        # with the programmed path.
        return arm_side(self.motion, log.time, self.motion.position + got - asked)


@lru_cache
def _arm(robot: str) -> CompiledRobot:
    return compile_robot(CELLS[robot].robot)


@dataclass(frozen=True)
class _Estimate:
    robot: str

    def __call__(self, experiment: Experiment, first: Pass) -> Reading:
        # Imported here, as below: the other sensors do without the estimator.
        from ..estimation.arm_learning import ArmLearningCfg, OnFault, commission
        from ..estimation.nominal import NominalCfg, nominal_arm

        xml = CELLS[self.robot].xml
        nominal = _nominal(self.robot)
        cfg = ArmLearningCfg(on_fault=OnFault.GO_ON)
        # The payload is known; the individual's springs are not.
        added = experiment.job.model.mj.body("tool").mass[0] - nominal.mj.body("tool").mass[0]
        arm = nominal_arm(xml, NominalCfg(payload=float(added)))
        known = commission(nominal, arm, ImuCfg(), first, cfg)
        return _EstimateReading(cfg, known, experiment.motion)


@lru_cache
def _nominal(robot: str) -> RobotModel:
    return load_model(CELLS[robot].xml)


@dataclass(frozen=True)
class _EstimateReading:
    cfg: "ArmLearningCfg"
    known: "Commissioned"
    motion: ToolMotion

    def __call__(self, cut: Pass) -> ArmSide:
        from ..estimation.arm_learning import measured_path

        moved = measured_path(self.cfg, self.known, ImuCfg(), cut)[:, :3]
        return arm_side(self.motion, cut.recording.time, self.motion.position[0] + moved)
