"""Learning on the arm side: what is taken for the tool's path, and the law that fits the arm.

The first run, before any learning, is also the one that the arm is identified from. What is
believed of the robot is its nominal model; the truth of a recording is read by the oracle only,
which marks what the best of all measurements could reach.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from armside.arrays import Array
from armside.ilc import learning
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic, Law
from armside.ilc.laws.guarded import Guarded
from armside.ilc.laws.joint_space import JointSpace
from armside.ilc.laws.law import FirstOrderLaw
from armside.ilc.laws.record_optimal import RecordOptimal
from armside.ilc.laws.regularised_inverse import RegularisedInverse

from ..instruments.imu import ImuCfg, ImuSamples
from ..laser.experiment import Experiment, Iteration, judged
from ..laser.plant import Pass
from ..robot.model import RobotModel
from ..robot.virtual_robot import LOG_PERIOD
from .arm_estimator import UNIDENTIFIED, ArmEstimator, Estimate, estimator
from .arm_filter import Distrust
from .arm_identification import REST, Identified, identify, prepared
from .arm_plant import ArmPlant
from .arm_springs import SpringPrior, Springs
from .frozen_arm import frozen
from .imu_health import Fault, ImuError, mended
from .nominal import NominalArm
from .tool_path import relative_to_start


class Measure(Enum):
    """Where the tool's path is taken from."""

    ESTIMATE = "estimate"
    """Motor angles and IMU."""
    TRACKER = "tracker"
    """The laser tracker: positions only."""
    TRUTH = "truth"
    """The oracle."""


class ArmLaw(Enum):
    """Laws for errors of the tool."""

    INVERSE = "inverse"
    NORM_OPTIMAL = "norm-optimal"
    HEURISTIC = "heuristic"


class OnFault(Enum):
    """What to do when the IMU cannot be used."""

    REFUSE = "refuse"
    """Do not learn."""
    GO_ON = "go-on"
    """Estimate from motor angles and model alone."""


_MISTRUSTED = 1.7
"""Of whitened innovations, rms: above, the identified model does not explain the readings. With the
robot's own model 1.0 to 1.4 were seen, with that of another posture 1.2 to 1.9. ESTIMATE."""
_UNLIKELY = 3.0
"""Standard deviations by which the IMU's seat may be off before the model is mistrusted."""
_TRACKER_FILTER = 40.0
"""[Hz], zero-phase low-pass of tracker positions before they are learned from."""


@dataclass(frozen=True, kw_only=True)
class ArmLearningCfg:
    """How to learn on the arm side."""

    measure: Measure = Measure.ESTIMATE
    law: ArmLaw = ArmLaw.INVERSE
    gamma: float = 0.8
    """Learning gain."""
    cutoff: float | None = None
    """Of Q [Hz]; `pass_band` of the programmed contour if None."""
    delta: int = 3
    """Time shift of the heuristic law [samples]."""
    turn_weight: float = 0.1
    """[m]: an error of 1 mrad of the tool's turn counts as one of 0.1 mm."""
    limit: float = 0.02
    """Of the correction: how far each axis may move the tool [m]."""
    repeats: int = 1
    """Runs that are averaged in each iteration."""
    guarded: bool = True
    """Back off when the estimate says that learning no longer helps."""
    estimate: Estimate = Estimate.SMOOTHER
    identified: bool = True
    """Springs are identified from the first run, and the law is built on them."""
    law_identified: bool = True
    """The law too is built on what was identified."""
    on_fault: OnFault = OnFault.REFUSE
    prior: SpringPrior = field(default_factory=SpringPrior)
    distrust: Distrust = field(default_factory=Distrust)

    def __post_init__(self) -> None:
        if self.repeats < 1:
            raise ValueError(f"repeats must be >= 1, got {self.repeats}")


@dataclass(frozen=True, kw_only=True, eq=False)
class Commissioned:
    """What the first run made known."""

    springs: Springs
    identified: Identified | None
    """None where springs were given, or where the IMU could not be used."""
    estimator: ArmEstimator
    plant: ArmPlant
    """That the law is built on."""
    fault: ImuError | None = field(default=None)
    """Why the IMU is not used."""


def commission(
    robot: RobotModel,
    arm: NominalArm,
    imu: ImuCfg,
    first: Pass,
    cfg: ArmLearningCfg,
    springs: Springs | None = None,
) -> Commissioned:
    """Identify the arm from a run, or take springs that are known already.

    Raises:
        ImuError: the IMU cannot be used, and `cfg.on_fault` refuses to go on.
    """
    log = first.recording
    rest = log.motor_angle[0]
    identified, fault = None, None
    try:
        if first.imu is None:
            raise ImuError(Fault.TOO_SHORT, "there is none")
        samples = mended(first.imu, imu)
        _upright(samples, frozen(arm, rest).imu_up, cfg)
        if springs is None and cfg.identified:
            run = prepared(arm, log.time, log.motor_angle, samples)
            identified = identify(arm, run, rest, imu, prior=cfg.prior, distrust=cfg.distrust)
            _believable(identified, cfg)
            springs = identified.springs
    except ImuError as problem:
        if cfg.on_fault is OnFault.REFUSE:
            raise
        identified, fault = None, problem
    nominal = Springs(
        stiffness=arm.stiffness,
        damping=arm.damping,
        clock_offset=0.0,
        distrust=UNIDENTIFIED,
        mounting=np.zeros(3),
    )
    believed = springs or nominal
    known = estimator(arm, believed, rest, imu, cfg.distrust)
    on = known if cfg.law_identified else estimator(arm, nominal, rest, imu, cfg.distrust)
    plant = ArmPlant(robot=robot, arm=on.model.arm, period=LOG_PERIOD)
    return Commissioned(
        springs=believed, identified=identified, estimator=known, plant=plant, fault=fault
    )


def _upright(samples: ImuSamples, up: Array, cfg: ArmLearningCfg) -> None:
    """Raise ImuError if gravity at rest is not where the model has it."""
    still = samples.acceleration[samples.time < samples.time[0] + 0.5 * REST]
    read = np.nanmean(still, axis=0)
    cosine = read @ up / (np.linalg.norm(read) * np.linalg.norm(up))
    turn = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    if turn > _UNLIKELY * cfg.prior.mounting:
        raise ImuError(Fault.MODEL, f"at rest gravity is {np.rad2deg(turn):.1f} deg off")


def _believable(found: Identified, cfg: ArmLearningCfg) -> None:
    """Raise ImuError if no springs make the model explain the readings."""
    worst = float(found.whiteness.rms.max())
    if worst > _MISTRUSTED:
        raise ImuError(Fault.MODEL, f"innovations are {worst:.1f} times what the filter expects")
    turn = float(np.abs(found.springs.mounting).max())
    if turn > _UNLIKELY * cfg.prior.mounting:
        degrees = np.rad2deg(turn)
        raise ImuError(Fault.MODEL, f"the IMU would have to be turned by {degrees:.1f} deg")


def pass_band(turns: float) -> float:
    """Cutoff of Q [Hz] for a contour that is gone round `turns` times a second.

    10 Hz. Of a fast contour the third harmonic has to pass, which it does with a gain of three
    quarters at four times the first; above 15 Hz the models that one run tells no longer serve.
    """
    return min(max(10.0, 4.0 * turns), 15.0)


def law(cfg: ArmLearningCfg, plant: ArmPlant, cutoff: float) -> Law:
    """The law on a plant's model, Q of a cutoff [Hz].

    Raises ValueError for design variables out of range.
    """
    turn = cfg.turn_weight if cfg.measure is not Measure.TRACKER else 0.0
    weight = (1.0, 1.0, 1.0, turn, turn, turn)
    size = tuple(float(s) for s in plant.input_size)
    low_pass = ZeroPhaseButterworth(cutoff, LOG_PERIOD)
    chosen: FirstOrderLaw
    if cfg.law is ArmLaw.INVERSE:
        chosen = RegularisedInverse(
            G=plant,
            sample_time=LOG_PERIOD,
            cutoff=cutoff,
            gamma=cfg.gamma,
            output_weight=weight,
            input_size=size,
            limit=cfg.limit,
        )
    elif cfg.law is ArmLaw.NORM_OPTIMAL:
        chosen = RecordOptimal(G=plant, F=low_pass, output_weight=weight, input_size=size)
    else:
        J = plant.arm.tool_jacobian[:, plant.arm.axes] * np.sign(weight)[:, None]
        heuristic = Heuristic(Q=low_pass, gamma=cfg.gamma, delta=cfg.delta)
        chosen = JointSpace(law=heuristic, inverse=np.asarray(np.linalg.pinv(J), dtype=np.float64))
    return Guarded(law=chosen, weight=weight) if cfg.guarded else chosen


def programmed_path(experiment: Experiment) -> Array:
    """(N, 6): what the tool is to do, from rest."""
    position = experiment.motion.position
    return relative_to_start(position)


def measured_path(cfg: ArmLearningCfg, known: Commissioned, imu: ImuCfg, run: Pass) -> Array:
    """(N, 6): what the tool did in a run, from rest, as `cfg.measure` has it.

    Raises:
        ImuError: the IMU failed in this run and `cfg.on_fault` refuses to go on.
    """
    log = run.recording
    if cfg.measure is Measure.TRUTH:
        every = round(LOG_PERIOD / float(log.truth.time[1]))
        return relative_to_start(
            log.truth.tool_position[::every], log.truth.tool_quaternion[::every]
        )
    if cfg.measure is Measure.TRACKER:
        return _tracked(log.time, run)
    samples = None
    if known.fault is None and run.imu is not None:
        try:
            samples = mended(run.imu, imu)
        except ImuError:
            if cfg.on_fault is OnFault.REFUSE:
                raise
    return known.estimator(log.time, log.motor_angle, samples, cfg.estimate).displacement


def _tracked(time: Array, run: Pass) -> Array:
    """Low-passed tracker positions at the instants of the log. A lost beam makes them NaN."""
    seen = run.tracker
    period = float(seen.time[1] - seen.time[0])
    smooth = ZeroPhaseButterworth(_TRACKER_FILTER, period)(seen.position)
    at = np.clip(np.rint(time / period).astype(int), 0, len(smooth) - 1)
    return relative_to_start(smooth[at])


@dataclass(frozen=True, kw_only=True)
class _Measured:
    """A run and the path that is learned from."""

    run: Pass
    path: Array


@dataclass(frozen=True)
class _MeasuringPlant:
    """The plant as the learning loop sees it; the first run has been made already."""

    experiment: Experiment
    first: Pass
    path_of: Callable[[Pass], Array]
    repeats: int

    def run(self, correction: Array, /) -> _Measured:
        runs = [self.first] if not correction.any() else [self.experiment.plant.run(correction)]
        runs += [self.experiment.plant.run(correction) for _ in range(self.repeats - 1)]
        return _Measured(run=runs[0], path=np.mean([self.path_of(run) for run in runs], axis=0))


def begin(
    experiment: Experiment,
    robot: RobotModel,
    arm: NominalArm,
    imu: ImuCfg,
    cfg: ArmLearningCfg,
    iterations: int,
    springs: Springs | None = None,
) -> tuple[Commissioned, Iterator[Iteration]]:
    """Make the first run, commission the arm, and hand out the iterations k = 0 .. iterations.

    Args:
        robot: the nominal robot: its servo is known.
        arm: the nominal arm: what is believed of springs and inertia.
        imu: the kind of unit at the tool, as its data sheet has it.
        springs: of an earlier identification at this pose.

    The loop ends early, its last trial marked `diverged`, when the learned displacement is not
    finite or its error exceeds three times that of k = 0.

    Raises:
        ImuError: the IMU cannot be used, and `cfg.on_fault` refuses to go on.
    """
    first = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
    known = commission(robot, arm, imu, first, cfg, springs)
    motion = experiment.motion
    turns = motion.programmed_speed / motion.path.curve.length
    cutoff = pass_band(turns) if cfg.cutoff is None else cfg.cutoff
    chosen = law(cfg, known.plant, cutoff)
    plant = _MeasuringPlant(
        experiment, first, lambda run: measured_path(cfg, known, imu, run), cfg.repeats
    )
    return known, _iterations(experiment, plant, chosen, iterations)


def _iterations(
    experiment: Experiment, plant: _MeasuringPlant, chosen: Law, iterations: int
) -> Iterator[Iteration]:
    limit = np.inf
    for trial in learning.learn(
        plant,
        chosen,
        programmed_path(experiment),
        iterations,
        output_of=lambda measured: measured.path,
        divergence_ratio=np.inf,
    ):
        size = float(np.linalg.norm(trial.error[:, :3]))
        diverged = trial.diverged or not size <= limit
        limit = 3.0 * size if trial.k == 0 else limit
        made = learning.Trial(
            k=trial.k,
            correction=trial.correction,
            output=trial.output,
            error=trial.error,
            result=trial.result.run,
            diverged=diverged,
        )
        yield judged(experiment, made)
        if diverged:
            return
