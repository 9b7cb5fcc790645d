"""What the reward is computed from: the tool as one of the cell's sensors has it.

A sensor is set up by the first run of an episode, the one without learning, and reads every run.
"""

from collections.abc import Callable
from enum import Enum
from functools import lru_cache

from kinematics import CompiledRobot
from kinematics import compile as compile_robot

from ..arm_side import ArmSide, arm_side
from ..cell import CELLS
from ..cutting import Pass
from ..experiment import Experiment
from ..instruments.imu import ImuCfg
from ..model import load_model

Reading = Callable[[Pass], ArmSide]
Sensor = Callable[[Experiment, Pass], Reading]


class Sees(Enum):
    """Which sensor the reward is computed from."""

    TRACKER = "tracker"
    """A laser tracker."""
    ESTIMATE = "estimate"
    """Motor angles and an IMU at the tool; the arm is identified from the first run of an episode,
    which takes seconds."""
    MOTOR = "motor"
    """The motor angles, as if nothing between them and the tool gave way."""

    def sensor(self, robot: str) -> Sensor:
        """Raises ValueError for a robot that the sensor cannot serve."""
        return {Sees.TRACKER: _tracker, Sees.ESTIMATE: _estimate, Sees.MOTOR: _motors}[self](robot)

    @property
    def imu(self) -> ImuCfg | None:
        """The unit that has to be at the tool."""
        return ImuCfg() if self is Sees.ESTIMATE else None


def _tracker(_robot: str) -> Sensor:
    def set_up(experiment: Experiment, _first: Pass) -> Reading:
        return lambda cut: arm_side(experiment.motion, cut.tracker.time, cut.tracker.position)

    return set_up


@lru_cache
def _motors(robot: str) -> Sensor:
    arm: CompiledRobot = compile_robot(CELLS[robot].robot)

    def set_up(experiment: Experiment, _first: Pass) -> Reading:
        motion = experiment.motion

        def reading(cut: Pass) -> ArmSide:
            log = cut.recording
            asked, got = (arm.pose(phi)[:, :3, 3] for phi in (log.reference, log.motor_angle))
            # r is shifted against the deflection that the controller expects: compare with r, not
            # with the programmed path.
            return arm_side(motion, log.time, motion.position + got - asked)

        return reading

    return set_up


@lru_cache
def _estimate(robot: str) -> Sensor:
    if robot != "large":
        raise ValueError(f"reward 'estimate' needs an open chain: the large robot, got {robot!r}")
    # Imported here: the other sensors do without the estimator.
    from ..estimation.arm_learning import ArmLearningCfg, OnFault, commission, measured_path
    from ..estimation.nominal import NominalCfg, nominal_arm

    cell = CELLS[robot]
    nominal = load_model(cell.xml)
    cfg = ArmLearningCfg(on_fault=OnFault.GO_ON)

    def set_up(experiment: Experiment, first: Pass) -> Reading:
        # The payload is known; the individual's springs are not.
        added = experiment.job.model.mj.body("tool").mass[0] - nominal.mj.body("tool").mass[0]
        arm = nominal_arm(cell.xml, NominalCfg(payload=float(added)))
        known = commission(nominal, arm, ImuCfg(), first, cfg)
        motion = experiment.motion

        def reading(cut: Pass) -> ArmSide:
            moved = measured_path(cfg, known, ImuCfg(), cut)[:, :3]
            return arm_side(motion, cut.recording.time, motion.position[0] + moved)

        return reading

    return set_up
