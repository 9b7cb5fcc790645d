"""The tool's path as measured output: by estimate, laser tracker, or ground truth."""

from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Law

from ..estimation.commissioning import Commissioned, Commissioning, OnFault, commission
from ..estimation.elasticity import ArmParameters
from ..estimation.estimator import ToolEstimate, Validity, validity
from ..estimation.imu_health import ImuError, repaired
from ..estimation.nominal import NominalArm, NominalCfg, assumed_arm
from ..estimation.relative_path import relative_to_start
from ..estimation.structure import with_structure
from ..estimation.tool_law import ToolLaw
from ..instruments.imu import ImuCfg, exact
from ..notes import Cause, Note
from ..robot.drives import gear_error_of
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from .experiment import Experiment, Pass
from .measures import SetUp

_TRACKER_FILTER = 40.0
"""[Hz], zero-phase low-pass of tracker positions before they are learned from."""


class Source(Enum):
    """Sensor of the tool's path."""

    ESTIMATE = "estimate"
    """Motor angles and IMU."""
    TRACKER = "tracker"
    """Laser tracker: positions only."""
    TRUTH = "truth"
    """Ground truth: the best of all sensors."""


@dataclass(frozen=True, kw_only=True)
class ToolPath:
    """Path of the tool from rest, and the law that is built on the arm commissioned for it."""

    source: Source = Source.ESTIMATE
    law: ToolLaw = field(default_factory=ToolLaw)
    commissioning: Commissioning = field(default_factory=Commissioning)
    structure: bool = True
    """The structure is taken to give way beside the first gears; else gears alone."""
    stiffness_error: float = 0.3
    """The stiffness of each gear is assumed wrong by up to this fraction, drawn with the seed."""
    payload_error: float = 0.0
    """Error of the assumed mass of the tool [kg]."""
    damping_factor: float = 1.0
    """Assumed damping of the gears over that of the file."""
    parameters: ArmParameters | None = None
    """Of this robot, identified earlier, in place of identifying from the first run."""
    imu: ImuCfg = field(default_factory=ImuCfg)
    """Kind of unit at the tool; its data sheet is known."""
    target: Recording | None = field(default=None, compare=False, repr=False)
    """Noise-free run of a model, such as a twin's, that is learned as the sensor sees it; the
    programmed path if None."""

    def assumed(self, experiment: Experiment) -> NominalArm:
        """The assumed arm. Raises ValueError for a model that no estimator can be built on."""
        known, nominal = experiment.cut.gear_error, experiment.nominal
        cfg = NominalCfg(
            structure=self.structure,
            damping=self.damping_factor,
            payload=experiment.added_payload + self.payload_error,
        )
        elastic = with_structure(nominal) if self.structure else nominal
        arm = assumed_arm(elastic, self.stiffness_error, experiment.seed, cfg)
        return replace(arm, gear_error=gear_error_of(known, nominal.n_axes)) if known else arm

    def prepare(self, experiment: Experiment) -> SetUp:
        """Raises ValueError as `assumed`."""
        arm = self.assumed(experiment)
        return lambda first: self.commissioned(experiment, arm, first)

    def commissioned(self, experiment: Experiment, arm: NominalArm, first: Pass) -> "ToolOutput":
        """The measure set up by a run; a tracker without an IMU has its law on the assumed springs.

        Raises ImuError where the estimate's IMU cannot be used, and the options refuse to go on.
        """
        robot, log, cfg = experiment.nominal, first.recording, self.commissioning
        if self.source is not Source.ESTIMATE:
            cfg = replace(cfg, on_fault=OnFault.GO_ON)
        known = commission(robot, arm, self.imu, log, first.imu, cfg, self.parameters)
        return ToolOutput(self, known, experiment)


@dataclass(frozen=True)
class ToolOutput:
    """Paths (N, 6) from rest, displacement [m] and rotation vector [rad], base axes."""

    measure: ToolPath
    known: Commissioned
    experiment: Experiment
    _validity: list[Validity] = field(default_factory=list, compare=False, repr=False)
    """Of the last estimate."""

    @property
    def reference(self) -> Array:
        """(N, 6), path to learn, from rest.

        A tracker sees the tool, and learns the programmed path. An estimate is off by what its arm
        does not have: in the run of a model as in the robot's, whose errors then show.
        """
        return self._reference

    @cached_property
    def _reference(self) -> Array:
        if self.measure.target is None or self.measure.source is not Source.ESTIMATE:
            return relative_to_start(self.experiment.programmed)
        return self._estimate_of(self.measure.target)

    @property
    def law(self) -> Law:
        """Law on the commissioned arm. Raises ValueError for design variables out of range.

        A tool whose orientation is free turns as its position asks: no error of the program.
        """
        turn_rate, free = self.experiment.turn_rate, self.experiment.cut.cell.free_rotation
        rotations = self.measure.source is not Source.TRACKER and not free
        return self.measure.law.along(self.known.plants, turn_rate, rotations=rotations)

    @property
    def notes(self) -> tuple[Note, ...]:
        """Why the IMU is not used, or where the estimate of the last run is not valid."""
        texts = [each.text for each in self._validity if each.text]
        if self.known.fault is not None:
            texts.insert(0, f"{self.known.fault}; the assumed springs are used instead")
        return tuple(Note(cause=Cause.IMU, text=text) for text in texts)

    def __call__(self, run: Pass) -> Array:
        """Path of a run. Where an estimate is not valid it is the reference: nothing is learned.

        Raises ImuError where the IMU failed in this run, and the options refuse to go on.
        """
        log, source = run.recording, self.measure.source
        if source is Source.TRUTH:
            every = round(LOG_PERIOD / float(log.truth.time[1]))
            position, quaternion = log.truth.tool_position, log.truth.tool_quaternion
            return relative_to_start(position[::every], quaternion[::every])
        if source is Source.TRACKER:  # low-passed, at the instants of the log; NaN of a lost beam
            seen, period = run.tracker, float(run.tracker.time[1] - run.tracker.time[0])
            smooth = ZeroPhaseButterworth(_TRACKER_FILTER, period)(seen.position)
            at = np.clip(np.rint(log.time / period).astype(int), 0, len(smooth) - 1)
            return relative_to_start(smooth[at])
        found = self.estimated(run)
        valid = validity(found, log.time)
        self._validity[:] = [valid]
        asked = self.reference
        return asked + valid.weight[:, None] * (found.displacement - asked)

    def estimated(self, run: Pass) -> ToolEstimate:
        """The estimate of a run, valid or not. Raises ImuError as a call."""
        log, samples = run.recording, None
        if self.known.fault is None and run.imu is not None:
            try:
                samples = repaired(run.imu, self.measure.imu)
            except ImuError:
                if self.measure.commissioning.on_fault is OnFault.REFUSE:
                    raise
        return self.known.estimator(log.time, log.motor_angle, samples)

    def _estimate_of(self, run: Recording) -> Array:
        """Path (N, 6) that is estimated of a model's run, by a unit without errors."""
        truth, samples = run.truth, None
        if self.known.fault is None:
            ideal = truth.time, truth.imu_acceleration, truth.imu_angular_velocity
            samples = exact(self.measure.imu).measure(*ideal, np.random.default_rng(0))
        estimator = self.known.estimator.of_model()
        return estimator(run.time, run.motor_angle, samples).displacement

    def size(self, error: Array) -> Array:
        """Norm of the displacement: orientations do not count."""
        return np.array([float(np.linalg.norm(error[:, :3]))])
