"""What learning would leave of a cut, said before its first run: from robots of the type.

An ensemble of the production line makes the cut and learns it in simulation, by what the controller
knows of the type: from its motors, and from its tool with the type's arm in law and estimator. r is
the tool's RMS after k updates over that without correction:

    motor       r, of motor-side learning
    tracker     r, of learning from the tracker on the springs of the type
    estimate    (r_tracker^2 + (a b)^2)^1/2   b: error of an estimate on those springs, over k = 0
    twin        (e^2 + (a s)^2)^1/2           e, s: left by the correction that the type's own model
                                              learned, in it and in each robot; the first run

a is what identification leaves of what it finds. log r of another robot is normal, with the mean of
the ensemble and a variance s^2 + sigma^2; a, a factor on the median and sigma were fitted to robots
and tasks of development (`tests/claims/forecast.py`), which are not those that judge.
"""

import copy
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtr, ndtri

from armside.arrays import Array

from ..estimation.arm_filter import FRACTION
from ..estimation.arm_plant import plants_along
from ..estimation.commissioning import Commissioned
from ..estimation.elasticity import ArmParameters, nominal_elasticity
from ..estimation.estimator import ToolEstimator
from ..estimation.nominal import NominalCfg, nominal_arm
from ..estimation.relative_path import relative_to_start
from ..estimation.rigid_motion import rigid_motion
from ..estimation.tool_law import ToolLaw
from ..instruments.imu import ImuCfg, exact
from ..robot.run import cores
from ..robot.spread import PRODUCTION, draw
from .experiment import Experiment, Pass, prepare
from .loop import iterate
from .measures import MotorAngles, SetUp
from .specification import Setup
from .tool_measure import Source, ToolOutput, ToolPath

UPDATES = (5, 20)
ROBOTS = 8
"""Of the ensemble: a circle then takes twelve seconds of processor, the half of it on two cores."""
_STREAM = 0xF0  # of the ensemble, apart from those of individuals and instruments
_OF_TWIN = ToolLaw(cutoff=30.0)
"""Law inside a twin, with its pass band [Hz]."""
_TWIN_UPDATES = 7
_STILL, _SETTLED = 0.01, 3
"""Relative change of the tool's RMS in so many updates running after which it stays. ESTIMATE"""
_LARGEST = 10.0
"""Share at which a run that diverged is counted."""
_NORMAL = float(ndtri(0.95))


class Calibration(NamedTuple):
    """Of one measure, fitted to development."""

    identified: float
    """a."""
    factor: float
    """On the median."""
    spread: float
    """sigma, of log r beyond the ensemble's."""


CALIBRATION: Mapping[str, Calibration] = {
    "motor": Calibration(1.0, 1.0, 0.08),
    "estimate": Calibration(0.5, 1.02, 0.12),
    "tracker": Calibration(1.0, 0.96, 0.12),
    "twin": Calibration(0.1, 0.68, 0.55),
}
"""Fitted on the large robot: of the estimate to fifteen robots of development with a task each, of
motors and tracker to 36 with twelve tasks, of a twin to nine with 48."""
CALIBRATED_ROBOT = "large"
"""Robot that intervals were fitted on."""


@dataclass(frozen=True, kw_only=True)
class Left:
    """Tool RMS over that without correction, of a robot of the type: 1 is no change."""

    measure: str
    """What is learned from; `twin`: the first run by a twin of ten cuts."""
    updates: int
    median: float
    low: float
    high: float
    """Ends of the interval of 90 %."""
    worse: float
    """Share of robots that end above 1."""
    calibrated: bool
    """The interval was fitted to robots of this type."""

    @property
    def words(self) -> str:
        """Such as "94 % (58 to 150)"."""
        low, high = 100.0 * self.low, 100.0 * self.high
        return f"{100.0 * self.median:.3g} % ({low:.3g} to {high:.3g})"


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """What learning would leave of a cut, by an ensemble of its robot's type."""

    uncorrected: float
    """Median tool RMS without correction [m]."""
    robots: int
    """In the ensemble."""
    left: tuple[Left, ...]
    assumed: tuple[str, ...] = ()
    """What it takes for granted and does not know of this cut."""

    def of(self, measure: str, updates: int) -> Left:
        """The entry of a measure whose updates are nearest. Raises ValueError for another name."""
        own = [each for each in self.left if each.measure == measure]
        if not own:
            names = ", ".join(dict.fromkeys(each.measure for each in self.left))
            raise ValueError(f"Unknown measure {measure!r}. Forecast are: {names}")
        return min(own, key=lambda each: abs(each.updates - updates))

    def objection(self, measure: str, updates: int) -> str | None:
        """Why a measure should not be learned from; None where most robots gain."""
        if updates == 0 or (own := self.of(measure, updates)).worse <= 0.5:
            return None
        others = {each.measure: self.of(each.measure, updates) for each in self.left}
        better = [f"{x.measure} {100 * x.median:.2g} %" for x in others.values() if x.worse < 0.5]
        instead = f"; the forecast of others: {', '.join(better)}" if better else ""
        doubt = "" if own.calibrated else ", not calibrated for this robot,"
        return (
            f"learning from {measure} is forecast to leave {own.words}{doubt} of the tool's "
            f"error after {own.updates} updates, and {100 * own.worse:.0f} % of robots end worse "
            f"than without{instead}"
        )


def forecast(
    cut: Setup[Any],
    *,
    motor: MotorAngles = MotorAngles(),
    law: ToolLaw = ToolLaw(),
    robots: int = ROBOTS,
    measures: Collection[str] = tuple(CALIBRATION),
    step: Callable[[], object] = lambda: None,
) -> Forecast:
    """Forecast of a cut by a robot of its type, whatever its individual: of that nothing is read,
    nor of a payload that the controller does not know.

    Args:
        motor, law: what motors and tool are learned with.
        robots: in the ensemble, 3 or more.
        measures: that are forecast; a twin's of the large robot alone.
        step: called after each robot.

    Raises ValueError for a cut that cannot be made, too few robots, or an unknown measure.
    """
    if unknown := [name for name in measures if name not in CALIBRATION]:
        raise ValueError(f"Unknown measure {unknown[0]!r}. Forecast are: {', '.join(CALIBRATION)}")
    fitted = cut.robot == CALIBRATED_ROBOT and cut.model is None
    wanted = set(measures) - (set() if cut.robot == "large" else {"twin"})
    if robots < 3:
        raise ValueError(f"robots must be >= 3, got {robots}")
    known = replace(
        cut,
        individual=None,
        friction_spread=0.0,
        friction_drift=0.0,
        temperature=None,
        gear_error=(),
        payload=cut.payload if cut.payload_known else None,
        payload_known=True,
        imu=None,
    )
    base = prepare(known)
    first = base.plant.run(np.zeros_like(base.loaded.reference))
    of_tool = ToolPath(source=Source.TRACKER, law=law, imu=cut.imu or ImuCfg())
    type_ = _Type(base, _known_arm(base, first, of_tool), motor, of_tool, frozenset(wanted))
    correction = type_.learned_in_model() if "twin" in wanted else None
    with ThreadPoolExecutor(cores()) as pool:
        found = list[Member]()
        for one in pool.map(lambda i: type_.member(i, correction), range(robots)):
            found.append(one)
            step()
    assumed = list[str]()
    if not fitted:
        assumed.append(
            f"its intervals are not calibrated for this robot: fitted on {CALIBRATED_ROBOT}"
        )
    if not cut.payload_known and cut.payload is not None:
        assumed.append(
            f"it is of the tool of the robot's file: that of {cut.payload:g} kg is unknown"
        )
    return replace(summarised(found, wanted, fitted), assumed=tuple(assumed))


@dataclass(frozen=True)
class Member:
    """One robot of an ensemble: tool RMS [m]."""

    without: float
    motor: Array
    tracker: Array
    """(U,) after `UPDATES`."""
    unseen: Array
    """(U,) error of the estimate in the runs of `tracker`."""
    by_model: float
    """In the first run with the correction that the type's model learned; NaN without one."""
    inside: float
    """Of that correction in the model itself."""


def shares(measure: str, one: Member, identified: float) -> Array:
    """(U,) or (1,): r of one robot of the ensemble, at most `_LARGEST`."""
    left = {
        "motor": one.motor,
        "tracker": one.tracker,
        "estimate": np.hypot(one.tracker, identified * one.unseen),
        "twin": np.array([np.hypot(one.inside, identified * one.by_model)]),
    }[measure]
    return np.minimum(np.nan_to_num(left / one.without, nan=_LARGEST), _LARGEST)


def summarised(
    found: list[Member], wanted: Collection[str] = tuple(CALIBRATION), fitted: bool = True
) -> Forecast:
    """Medians and intervals from the robots of an ensemble. fitted: of the calibrated robot."""
    left = list[Left]()
    for measure, (identified, factor, spread) in CALIBRATION.items():
        if measure not in wanted:
            continue
        logs = np.log([shares(measure, one, identified) for one in found])
        mean, width = logs.mean(axis=0) + np.log(factor), np.hypot(logs.std(axis=0, ddof=1), spread)
        for k, m, w in zip(UPDATES if measure != "twin" else (0,), mean, width, strict=True):
            low, middle, high = np.exp(m + _NORMAL * w * np.array([-1.0, 0.0, 1.0]))
            left.append(
                Left(
                    measure=measure,
                    updates=k,
                    median=float(middle),
                    low=float(low),
                    high=float(high),
                    worse=float(ndtr(m / w)),
                    calibrated=fitted,
                )
            )
    without = float(np.median([one.without for one in found]))
    return Forecast(uncorrected=without, robots=len(found), left=tuple(left))


def _known_arm(base: Experiment, first: Pass, measure: ToolPath) -> Commissioned:
    """Estimator and plants on the springs of the robot's file, gears and structure."""
    robot, log = base.nominal, first.recording
    arm = nominal_arm(robot, NominalCfg(structure=True, payload=base.added_payload))
    motion, springs = rigid_motion(arm, log.time, log.motor_angle), nominal_elasticity(robot, arm)
    parameters = ArmParameters(springs, 0.0, FRACTION, np.zeros(3))
    hard = motion.excitation(robot)
    plants = plants_along(robot, motion, springs, identified=True, excitation=hard)
    estimator = ToolEstimator(arm, parameters, measure.imu, motion)
    return Commissioned(parameters, None, estimator, plants, None, springs)


@dataclass(frozen=True)
class _Type:
    """A cut, and what is known of the robot's type."""

    base: Experiment
    arm: Commissioned
    motor: MotorAngles
    tool: ToolPath
    wanted: frozenset[str]

    def learned_in_model(self) -> tuple[Array, float]:
        """The best correction (N, n) [rad] of the type's model of itself, and its tool RMS [m]."""
        truth = ToolPath(source=Source.TRUTH, law=_OF_TWIN)
        runs = list(iterate(self.base, self._learning(self.base, truth), _TWIN_UPDATES))
        best = min(runs, key=lambda it: it.tool_true.rms)
        return best.correction, best.tool_true.rms

    def member(self, number: int, learned: tuple[Array, float] | None) -> Member:
        """One robot of the ensemble makes the cut and learns it."""
        base, rng = self.base, np.random.default_rng([number, _STREAM])
        individual = draw(rng, base.nominal, PRODUCTION)
        robot = prepare(replace(base.cut, individual=individual), seed=number)
        motor = tracker = unseen = np.full(len(UPDATES), np.nan)
        by_model = inside = np.nan
        without = _rms(robot, *robot.plant.run(np.zeros_like(robot.loaded.reference)).true)
        if "motor" in self.wanted:
            motor, _ = self._loop(robot, self.motor.prepare(robot), lambda run: np.nan)
        if self.wanted & {"estimate", "tracker"}:
            set_up = self._learning(robot, self.tool)
            tracker, unseen = self._loop(robot, set_up, lambda run: self._unseen(robot, run))
        if learned is not None:
            correction, inside = learned
            by_model = _rms(robot, *robot.plant.run(correction).true)
        return Member(without, motor, tracker, unseen, by_model, inside)

    def _learning(self, robot: Experiment, measure: ToolPath) -> SetUp:
        return lambda first: ToolOutput(measure, self.arm, robot)

    def _loop(
        self, robot: Experiment, set_up: SetUp, unseen: Callable[[Pass], float]
    ) -> tuple[Array, Array]:
        """(U,) each [m]: tool RMS after `UPDATES`, and what is unseen of it; infinite where it has
        diverged before. One that has settled stays as it is."""
        noise = replace(robot.plant, rng=copy.deepcopy(robot.plant.rng))
        left, rms = np.full((2, len(UPDATES)), np.inf), list[float]()
        for it in iterate(robot, set_up, max(UPDATES), plant=noise):
            if it.diverged:
                break
            rms.append(it.tool_true.rms)
            change = np.abs(np.diff(rms[-1 - _SETTLED :])) / rms[-1]
            settled = len(change) == _SETTLED and bool((change < _STILL).all())
            if it.k in UPDATES or settled:
                left[:, [k >= it.k for k in UPDATES]] = [[rms[-1]], [unseen(it.run)]]
            if settled:
                break
        return left[0], left[1]

    def _unseen(self, robot: Experiment, run: Pass) -> float:
        """Error [m] of an estimate by a unit without noise, on the springs of the type."""
        log, truth = run.recording, run.recording.truth
        ideal = truth.time, truth.imu_acceleration, truth.imu_angular_velocity
        samples = exact(self.tool.imu).measure(*ideal, np.random.default_rng(0))
        seen = self.arm.estimator.of_model()(log.time, log.motor_angle, samples).displacement
        every = round(float(log.time[1] / truth.time[1]))
        true = relative_to_start(truth.tool_position[::every])
        programmed = robot.programmed[: len(seen)]
        return _rms(robot, log.time, programmed + (seen - true)[:, :3])


def _rms(robot: Experiment, time: Array, position: Array) -> float:
    cut, motion = robot.cut, robot.motion
    return cut.whole(motion, cut.errors(motion, time, position, edges=False)).rms
