"""Commissioning of an arm estimator from one run: repair the IMU's samples, identify, check.

The robot's nominal model is assumed; no ground truth is read.
"""

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import Whiteness

from ..instruments.imu import ImuCfg, ImuSamples
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from .arm_estimator import UNIDENTIFIED, ArmEstimator, estimator
from .arm_filter import ProcessNoise
from .arm_identification import REST, Identified, identify, prepared, synchronised
from .arm_plant import ArmPlant
from .arm_springs import SpringPrior, Springs
from .imu_health import Fault, ImuError, repaired
from .linearised_arm import linearised
from .nominal import NominalArm

_LARGEST_INNOVATION = 1.7
"""RMS of whitened innovations; above, the identified model does not explain the readings. With the
robot's own model 1.0 to 1.4 were seen, with that of another posture 1.2 to 1.9. ESTIMATE."""
_UNLIKELY = 3.0
"""Standard deviations of the prior by which the IMU's mounting, or what the arm's model leaves
unexplained, may be off before the model is rejected."""


class OnFault(Enum):
    """Reaction to an IMU that cannot be used."""

    REFUSE = "refuse"
    """Do not learn."""
    GO_ON = "go-on"
    """Estimate from motor angles and model alone."""


@dataclass(frozen=True, kw_only=True)
class Commissioning:
    """Options of commissioning."""

    identified: bool = True
    """Springs are identified from the first run."""
    law_identified: bool = True
    """The plant model of the law too is built on identified springs."""
    on_fault: OnFault = OnFault.REFUSE
    prior: SpringPrior = field(default_factory=SpringPrior)
    process_noise: ProcessNoise = field(default_factory=ProcessNoise)


@dataclass(frozen=True, eq=False)
class Commissioned:
    """Result of commissioning."""

    springs: Springs
    identified: Identified | None
    """None where springs were given, or where the IMU could not be used."""
    estimator: ArmEstimator
    plant: ArmPlant
    """Plant model of the law."""
    fault: ImuError | None
    """Fault for which the IMU is not used."""
    lowest_mode: float = 0.0
    """Of the plant's arm [Hz], motors held, where its springs were identified; else 0."""


def commission(
    robot: RobotModel,
    arm: NominalArm,
    imu: ImuCfg,
    log: Recording,
    samples: ImuSamples | None,
    cfg: Commissioning = Commissioning(),
    springs: Springs | None = None,
) -> Commissioned:
    """Identify the arm from a run, or take springs that are known and find the IMU's clock again.

    Args:
        robot: the nominal robot: its servo is known.
        arm: the assumed arm: springs and inertia.
        imu: the kind of unit at the tool, as its data sheet has it.
        log, samples: of the run; no ground truth is read.
        springs: of an earlier identification of this robot.

    Raises:
        ImuError: the IMU cannot be used, and `cfg.on_fault` refuses to go on.
    """
    rest = log.motor_angle[0]
    identified, fault = None, None
    try:
        if samples is None:
            raise ImuError(Fault.TOO_SHORT, "there is none")
        readings = repaired(samples, imu)
        check_gravity(readings, linearised(arm, rest).imu_up, cfg)
        how: Any = {"prior": cfg.prior, "process_noise": cfg.process_noise}
        if springs is not None:
            run = prepared(arm, log.time, log.motor_angle, readings)
            springs, white = synchronised(arm, springs, run, rest, imu, **how)
            check_model(springs, white, cfg)
        elif cfg.identified:
            run = prepared(arm, log.time, log.motor_angle, readings)
            identified = identify(arm, run, rest, imu, **how)
            check_model(identified.springs, identified.whiteness, cfg)
            springs = identified.springs
    except ImuError as problem:
        if cfg.on_fault is OnFault.REFUSE:
            raise
        identified, fault = None, problem
    nominal = Springs(arm.stiffness, arm.damping, 0.0, UNIDENTIFIED, np.zeros(3))
    assumed = springs or nominal
    known = estimator(arm, assumed, rest, imu, cfg.process_noise)
    on = known if cfg.law_identified else estimator(arm, nominal, rest, imu, cfg.process_noise)
    plant = ArmPlant(robot=robot, arm=on.model.arm, period=LOG_PERIOD)
    trusted = springs is not None and cfg.law_identified
    lowest = float(plant.arm.locked_modes()[0]) if trusted else 0.0
    return Commissioned(assumed, identified, known, plant, fault, lowest)


def check_gravity(samples: ImuSamples, up: Array, cfg: Commissioning) -> None:
    """Raise ImuError if gravity at rest is not where the model has it."""
    still = samples.acceleration[samples.time < samples.time[0] + 0.5 * REST]
    read = np.nanmean(still, axis=0)
    cosine = read @ up / (np.linalg.norm(read) * np.linalg.norm(up))
    angle = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    if angle > _UNLIKELY * cfg.prior.mounting:
        raise ImuError(Fault.MODEL, f"at rest gravity is {np.rad2deg(angle):.1f} deg off")


def check_model(springs: Springs, white: Whiteness, cfg: Commissioning) -> None:
    """Raise ImuError if the springs do not make the model explain the readings."""
    worst = float(white.rms.max())
    if worst > _LARGEST_INNOVATION:
        raise ImuError(Fault.MODEL, f"innovations are {worst:.1f} times what the filter expects")
    more = springs.process_noise / cfg.process_noise.fraction
    if more > np.exp(_UNLIKELY * cfg.prior.process_noise):
        unexplained = f"the arm's springs leave {more:.0f} times as much unexplained as expected"
        raise ImuError(Fault.MODEL, f"{unexplained}; identify them from a slower cut")
    angle = float(np.abs(springs.mounting).max())
    if angle > _UNLIKELY * cfg.prior.mounting:
        turned = f"the IMU would have to be turned by {np.rad2deg(angle):.1f} deg"
        raise ImuError(Fault.MODEL, turned)
