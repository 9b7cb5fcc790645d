"""Commissioning of an estimator from one run: repair the IMU's samples, identify, check.

The robot's nominal model is assumed; no ground truth is read.
"""

from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import Whiteness

from ..instruments.imu import ImuCfg, ImuSamples
from ..robot.model import RobotModel
from ..robot.recording import Recording
from .arm_filter import FRACTION
from .arm_plant import PathPlants, plants_along
from .elasticity import ArmParameters, Elasticity, SpringPrior, nominal_elasticity
from .estimator import ToolEstimator
from .identification import Identified, identify, synchronised
from .imu_health import REST, Fault, ImuError, repaired
from .nominal import NominalArm
from .rigid_motion import rigid_motion
from .tool_covariance import tool_covariance
from .tool_law import HARD

EXCERPT = 10.0
"""Length of the record that springs are identified from [s]."""
UNIDENTIFIED = 0.3
"""As `arm_filter.FRACTION`, of an arm whose springs were not identified."""
_LARGEST_INNOVATION = 1.7
"""RMS of whitened innovations; above, the identified model does not explain the readings. With the
robot's own model 1.0 to 1.4 were seen, with that of another posture 1.2 to 1.9. ESTIMATE."""
_UNLIKELY = 3.0
"""Standard deviations of the prior by which the IMU's mounting, or what the arm's model leaves
unexplained, may be off before the model is rejected."""
_OF_HARD = 2.0
"""Factor on that of a hard motion. The square at p2 at 12.5 m/s^2 leaves 5.3 to 5.8 times what is
expected (seeds 0, 10000 to 10002); this allows 9. With a payload that is wrong by 50 kg it leaves
20, by -35 kg 16 to 67. ESTIMATE"""


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


@dataclass(frozen=True, eq=False)
class Commissioned:
    """Estimator along a reference, and the plants of the law."""

    parameters: ArmParameters
    identified: Identified | None
    """None where parameters were given, or where the IMU could not be used."""
    estimator: ToolEstimator
    plants: PathPlants
    fault: ImuError | None
    """Fault for which the IMU is not used."""
    nominal: Elasticity = field(repr=False)
    """Springs that were assumed."""

    def tool_covariance(self, robot: RobotModel) -> Array:
        """(N, 3, 3) [m^2] of the displacement from rest in the first run.

        Raises ValueError where nothing was identified.
        """
        if self.identified is None:
            raise ValueError("the covariance is that of an identification, and there is none")
        return tool_covariance(self.estimator, self.identified.fit, self.nominal, robot)


def commission(
    robot: RobotModel,
    arm: NominalArm,
    imu: ImuCfg,
    log: Recording,
    samples: ImuSamples | None,
    cfg: Commissioning = Commissioning(),
    known: ArmParameters | None = None,
) -> Commissioned:
    """Identify an arm from the beginning of a run, or take parameters that are known.

    Args:
        robot: the nominal robot: its servo is known, and the lost motion of its type.
        arm: the assumed arm: inertia, and springs of gears and structure.
        imu: the kind of unit at the tool, as its data sheet has it.
        log, samples: of the run; no ground truth is read.
        known: of an earlier identification of this robot. Clock and mounting are found again.

    Raises:
        ImuError: the IMU cannot be used, and `cfg.on_fault` refuses to go on.
    """
    motion, nominal = rigid_motion(arm, log.time, log.motor_angle), nominal_elasticity(robot, arm)
    excitation = motion.excitation(robot)
    identified, found, fault = None, None, None
    try:
        if samples is None:
            raise ImuError(Fault.TOO_SHORT, "there is none")
        readings = repaired(samples, imu)
        _check_gravity(readings, motion.up[0], cfg.prior)
        early, n = (
            motion.beginning(EXCERPT),
            np.searchsorted(readings.time - readings.time[0], EXCERPT),
        )
        readings = replace(readings, **{name: each[:n] for name, each in vars(readings).items()})
        if known is not None:
            found, white = synchronised(early, known, readings, imu, cfg.prior)
            _check_model(found, white, cfg.prior, excitation)
        elif cfg.identified:
            identified = identify(early, nominal, readings, imu, cfg.prior)
            found = identified.parameters
            _check_model(found, identified.whiteness, cfg.prior, excitation)
    except ImuError as problem:
        if cfg.on_fault is OnFault.REFUSE:
            raise
        identified, found, fault = None, known, problem
    assumed = ArmParameters(nominal.on_rigid_structure, 0.0, UNIDENTIFIED, np.zeros(3))
    parameters = assumed if found is None else found
    of_law = parameters if cfg.law_identified else assumed
    of_arm = found is not None and cfg.law_identified
    plants = plants_along(robot, motion, of_law.springs, identified=of_arm, excitation=excitation)
    estimator = ToolEstimator(arm, parameters, imu, motion)
    return Commissioned(parameters, identified, estimator, plants, fault, nominal)


def _check_gravity(samples: ImuSamples, up: Array, prior: SpringPrior) -> None:
    """Raise ImuError if gravity at rest is not where the model has it."""
    still = samples.acceleration[samples.time < samples.time[0] + 0.5 * REST]
    read = np.nanmean(still, axis=0)
    cosine = read @ up / (np.linalg.norm(read) * np.linalg.norm(up))
    angle = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    if angle > _UNLIKELY * prior.mounting:
        raise ImuError(Fault.MODEL, f"at rest gravity is {np.rad2deg(angle):.1f} deg off")


def _check_model(
    found: ArmParameters, white: Whiteness, prior: SpringPrior, excitation: float
) -> None:
    """Raise ImuError if the springs do not make the model explain the readings."""
    worst = float(white.rms.max())
    if worst > _LARGEST_INNOVATION:
        raise ImuError(Fault.MODEL, f"innovations are {worst:.1f} times what the filter expects")
    more = found.process_noise / FRACTION
    allowed = np.exp(_UNLIKELY * prior.process_noise) * (_OF_HARD if excitation >= HARD else 1.0)
    if more > allowed:
        unexplained = f"the arm's springs leave {more:.0f} times as much unexplained as expected"
        raise ImuError(Fault.MODEL, f"{unexplained}; identify them from a slower cut")
    angle = float(np.abs(found.mounting).max())
    if angle > _UNLIKELY * prior.mounting:
        turned = f"the IMU would have to be turned by {np.rad2deg(angle):.1f} deg"
        raise ImuError(Fault.MODEL, turned)
