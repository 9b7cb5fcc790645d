"""The tool's path along the way as measured output, trusted or not from place to place."""

from dataclasses import dataclass, field

from armside.arrays import Array
from armside.ilc.laws import Law

from ..estimation.arm_estimator import Estimate, estimator
from ..estimation.assumed_arm import assumed_arm
from ..estimation.commissioning import Commissioned, OnFault
from ..estimation.imu_health import ImuError
from ..estimation.nominal import NominalArm
from ..estimation.tool_law import ToolLawKind
from ..estimation.way.commissioning import WayCommissioned, commission_way
from ..estimation.way.joints import with_structure
from ..estimation.way.law import scheduled
from ..estimation.way.trust import Trust, trust
from ..instruments.imu import ImuSamples
from ..notes import Cause, Note
from ..robot.drives import EXACT, gear_error_of
from ..robot.recording import Recording
from .experiment import Experiment, Pass
from .tool_measure import Source, ToolOutput, ToolPath

SIX = 6
"""Axes of an arm whose structure is taken to stand beside its first three gears."""


@dataclass(frozen=True, kw_only=True)
class PathAlongWay(ToolPath):
    """Path of the tool that is estimated along the way.

    What is known for one place only (given springs, another filter or law, a model's run as target,
    an arm with closed chains or without six axes) is estimated there, as `ToolPath` does.
    """

    def commissioned(self, experiment: Experiment, arm: NominalArm, first: Pass) -> ToolOutput:
        """The measure set up by a run. Raises ImuError as `ToolPath.commissioned`."""
        if not self.follows(experiment, arm):
            return super().commissioned(experiment, arm, first)
        try:
            found = self._along(experiment, first)
        except ImuError:
            if self.source is Source.ESTIMATE and self.commissioning.on_fault is OnFault.REFUSE:
                raise
            return super().commissioned(experiment, arm, first)
        gears = found.gears
        rest = first.recording.motor_angle[0]
        local = estimator(arm, gears, rest, self.imu, self.commissioning.process_noise)
        plant = found.plants[len(found.plants) // 2]
        known = Commissioned(gears, None, local, plant, None)
        return WayOutput(self, known, experiment, found)

    def follows(self, experiment: Experiment, arm: NominalArm) -> bool:
        """Whether the path is estimated along its way."""
        one_place = self.springs is not None or self.target is not None
        usual = self.commissioning.identified and self.estimate is Estimate.SMOOTHER
        usual = usual and self.law.kind is ToolLawKind.INVERSE and arm.motion.is_open
        usual = usual and experiment.nominal.n_axes == SIX
        return usual and not one_place

    def _along(self, experiment: Experiment, first: Pass) -> WayCommissioned:
        known, nominal = experiment.setup.gear_error, with_structure(experiment.nominal)
        arm = assumed_arm(
            nominal,
            self.stiffness_error,
            experiment.seed,
            gear_error=gear_error_of(known, nominal.n_axes) if known else EXACT,
            damping=self.damping_factor,
            payload=experiment.added_payload + self.payload_error,
        )
        cfg, log = self.commissioning, first.recording
        return commission_way(experiment.nominal, arm, self.imu, log, first.imu, cfg)


@dataclass(frozen=True)
class WayOutput(ToolOutput):
    """Paths (N, 6) from rest along the way.

    Where an estimate is not trusted, it is taken to be what is asked for: nothing is learned there.
    """

    way: WayCommissioned
    _doubts: list[Trust] = field(default_factory=list, compare=False, repr=False)

    @property
    def law(self) -> Law:
        """Law on the arm at places along the way. Raises ValueError as `ToolOutput.law`."""
        known = self.way.plants, self.way.places
        free = self.experiment.setup.cell.free_rotation
        rotations = self.measure.source is not Source.TRACKER and not free
        motion, rate = self.way.estimator.along, self.experiment.turn_rate
        return scheduled(self.measure.law, known, motion, rate, rotations=rotations)

    @property
    def notes(self) -> tuple[Note, ...]:
        """Where the estimate of the last run was not trusted."""
        texts = [each.text for each in self._doubts[-1:] if each.text]
        return (*super().notes, *(Note(cause=Cause.IMU, text=text) for text in texts))

    def _estimated(self, log: Recording, samples: ImuSamples | None) -> Array:
        found = self.way.estimator(log.time, log.motor_angle, samples)
        doubts = trust(found, log.time)
        self._doubts[:] = [doubts]
        asked = self.reference
        return asked + doubts.weight[:, None] * (found.displacement - asked)
