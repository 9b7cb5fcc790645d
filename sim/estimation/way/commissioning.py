"""Commissioning of an estimator along a way: repair the IMU's samples, identify, check."""

from dataclasses import dataclass, field, replace

import numpy as np

from armside.arrays import Array

from ...instruments.imu import ImuCfg, ImuSamples
from ...robot.model import RobotModel
from ...robot.recording import Recording
from ..arm_plant import ArmPlant
from ..arm_springs import Springs
from ..commissioning import Commissioning, check_gravity, check_model
from ..imu_health import Fault, ImuError, repaired
from ..nominal import NominalArm
from .covariance import tool_covariance
from .elasticity import Elasticity, nominal_elasticity
from .estimator import WayEstimator
from .identification import WayIdentified, identify
from .law import plants
from .rigid_motion import RigidMotion, rigid_motion

EXCERPT = 10.0
"""Length of the record that springs are identified from [s]."""


@dataclass(frozen=True, eq=False)
class WayCommissioned:
    """Estimator along a reference, and the plants of the law."""

    identified: WayIdentified
    estimator: WayEstimator
    plants: tuple[ArmPlant, ...]
    places: np.ndarray
    """(S,) sample of the log at which each plant is."""
    nominal: Elasticity = field(repr=False)
    """Springs that were assumed."""

    def tool_covariance(self, robot: RobotModel) -> Array:
        """(N, 3, 3) [m^2] of the displacement from rest in the first run."""
        return tool_covariance(self.estimator, self.identified.fit, self.nominal, robot)

    @property
    def gears(self) -> Springs:
        """Springs of the gears, without those of the structure."""
        known = self.identified.constants
        K, D, axes = known.springs.stiffness, known.springs.damping, known.springs.axes
        rest = known.clock_offset, known.process_noise, known.mounting
        return Springs(np.diag(K[axes]), D[axes], *rest)


def commission_way(
    robot: RobotModel,
    arm: NominalArm,
    imu: ImuCfg,
    log: Recording,
    samples: ImuSamples | None,
    cfg: Commissioning = Commissioning(),
) -> WayCommissioned:
    """Identify an arm from the beginning of a run.

    Args:
        robot: the nominal robot: its servo is known, and the lost motion of its type.
        arm: the assumed arm with its structure: `joints.with_structure`.
        log, samples: of the run; no ground truth is read.

    Raises ImuError for an IMU that cannot be used.
    """
    if samples is None:
        raise ImuError(Fault.TOO_SHORT, "there is none")
    readings = repaired(samples, imu)
    motion = rigid_motion(arm, log.time, log.motor_angle)
    check_gravity(readings, motion.reading[0, :3], cfg)
    nominal = nominal_elasticity(robot, arm)
    part, short = beginning(motion, EXCERPT), _beginning(readings, EXCERPT)
    found = identify(part, nominal, short, imu, process_noise=cfg.process_noise)
    known = WayEstimator(arm, found.constants, imu, cfg.process_noise, motion)
    law_springs = found.constants.springs if cfg.law_identified else nominal
    result = WayCommissioned(found, known, *plants(robot, motion, law_springs), nominal)
    check_model(result.gears, found.whiteness, cfg)
    return result


def beginning(motion: RigidMotion, seconds: float) -> RigidMotion:
    """The first seconds of a motion."""
    n = int(np.searchsorted(motion.time, seconds))
    names = ("time", "phi", "load", "reading", "imu_jacobian", "imu_gravity", "segment")
    return replace(motion, **{name: getattr(motion, name)[:n] for name in names})


def _beginning(samples: ImuSamples, seconds: float) -> ImuSamples:
    n = int(np.searchsorted(samples.time - samples.time[0], seconds))
    names = ("time", "acceleration", "angular_velocity")
    names = (*names, "acceleration_clipped", "angular_velocity_clipped")
    return replace(samples, **{name: getattr(samples, name)[:n] for name in names})
