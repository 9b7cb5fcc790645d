"""Commissioning of a twin: the cuts to make, their check against the nominal robot, identification.

Candidates are circles and polygons, slow and fast, at poses over the workspace. They are taken one
by one, each kind of contour in turn, of each kind the one that adds most to log det of the
information about all parameters (D-optimal, greedy). So a shorter plan is the beginning of a longer
one, and what no parameter knows of has a chance to show in each kind of motion.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array

from ..cell import TOOL_QUATERNION, ToolPose
from ..laser.experiment import prepare
from ..laser.specification import Cut
from ..motion.contour import Circle, ClosedCurve, hexagon, square
from ..robot.effects import gear_phases
from ..robot.individual import Individual
from ..robot.mjcf import N_AXES
from ..robot.recording import Recording
from .identification import (
    CORRELATION,
    Identification,
    IdentifiedParameters,
    identify,
    parameters_of,
)
from .imu_sensor import IMU
from .own_servo import own_servo, refined
from .recordings import ImplausibleError, MeasuredCut, SensorName, measured, measured_from
from .scan_sensor import SCAN
from .sensitivities import Against
from .simulation import RobotDesign, design_of, motor_path, robot_digest, tool_path
from .tool_sensor import TRACKER, ToolSensor
from .twin import Twin

_CONTOURS: tuple[tuple[ClosedCurve, float], ...] = (
    (Circle(0.020), 0.080),
    (Circle(0.007), 0.085),
    (hexagon(0.012, 0.0018), 0.030),
    (square(0.030, 0.0045), 0.070),
)
"""Contour and speed [m/s]: slow and fast, smooth and with corners."""
_PLACES = (
    (1.3166, 0.0014, 1.5992),
    (1.8, 0.1, 1.5992),
    (2.2, 0.2, 1.5992),
    (1.5, -0.6, 1.2),
    (1.7, 0.7, 1.9),
    (2.1, -0.5, 1.3),
    (1.3, 0.6, 1.1),
    (1.9, 0.5, 1.1),
)
"""[m], TCP0 in base axes: p1, p2, p3 of thesis (9.3), and five around them."""
CANDIDATES = tuple(
    Cut(pose=ToolPose(place, TOOL_QUATERNION), contour=contour, speed=speed)
    for place in _PLACES
    for contour, speed in _CONTOURS
)
"""Of the large robot."""
_ORDER = (11, 0, 22, 17, 23, 24, 10, 1, 19, 12)
"""The first ten of `chosen`, by number of the candidate: `armside commission --choose`."""
MOST = len(_ORDER)


def plan(count: int) -> tuple[Cut, ...]:
    """The best few cuts. Raises ValueError for a count that is not from 1 to `MOST`."""
    if not 1 <= count <= MOST:
        raise ValueError(f"cuts must be from 1 to {MOST}, got {count}")
    return tuple(CANDIDATES[i] for i in _ORDER[:count])


def recorded(cut: Cut, name: str, seed: int) -> MeasuredCut:
    """Record of an uncorrected cut by the virtual robot. Raises ValueError as `prepare`."""
    experiment = prepare(cut, seed=seed)
    return measured(experiment.plant.run(np.zeros_like(experiment.loaded.reference)), name)


@dataclass(frozen=True)
class Choice:
    """A candidate that was taken, and what it adds."""

    number: int
    gain: float
    """Of log det of the information [nat]."""


def chosen(
    design: RobotDesign,
    count: int = MOST,
    candidates: Sequence[Cut] = CANDIDATES,
    progress: Callable[[], None] = lambda: None,
) -> list[Choice]:
    """The most informative candidates for individuals of a design, in the order they are taken."""
    parameters = parameters_of(design)
    whole = np.diag(parameters.standard_deviation**-2.0)
    each = []
    for cut in candidates:
        each.append(_information(design, cut))
        progress()
    taken = list[Choice]()
    for _ in range(count):
        used = [candidates[choice.number].curve for choice in taken]
        rarest = min(used.count(cut.curve) for cut in candidates)
        now = float(np.linalg.slogdet(whole)[1])
        gains = {
            i: float(np.linalg.slogdet(whole + each[i])[1]) - now
            for i, cut in enumerate(candidates)
            if used.count(cut.curve) == rarest and all(i != one.number for one in taken)
        }
        best = max(gains, key=lambda i: gains[i])
        taken.append(Choice(best, gains[best]))
        whole = whole + each[best]
    return taken


def _information(design: RobotDesign, cut: Cut) -> Array:
    """Information of a cut about an individual like the design."""
    parameters = parameters_of(design)
    reference = prepare(replace(cut, friction_spread=0.0)).loaded.reference
    nominal = parameters.individual(parameters.mean, np.zeros((N_AXES, 4)))
    run = design.run([nominal], reference, np.zeros_like(reference))[0]
    made = measured_from(run, "nominal")
    made = replace(made, motor_angle=motor_path(run), tool=tool_path(run))
    _, columns = Against(design, parameters, made).linearised(parameters.mean)
    torque = CORRELATION * _TORQUE * design.model.drives.torque_limit
    information = np.zeros((parameters.size, parameters.size))
    for axis in range(N_AXES):
        A = columns.torque[made.moving, axis] / torque[axis]
        information += A.T @ A
    A = columns.tool.reshape(-1, parameters.size) / (CORRELATION * _TOOL)
    return information + A.T @ A


_TORQUE, _TOOL = 2e-3, 1e-5
"""Residuals to expect: of torque over its limit, and of the tool [m]; as with hidden hinges."""


SENSORS: Mapping[SensorName, ToolSensor] = {"tracker": TRACKER, "imu": IMU, "scan": SCAN}

_LARGEST_ERROR = 0.02
"""[rad], of a motor from its reference: ten times what a cut at full speed shows. ESTIMATE."""
_TORQUE_GAIN = 0.6, 1.6
"""Measured torque over that of the nominal robot, least squares over all axes. Friction differs by
a third between robots, units by more. ESTIMATE."""
_OUTLIER = 5.0
"""Held-out residual of a cut over the median of all, above which it is called corrupt. ESTIMATE."""


def checked_against(
    design: RobotDesign, cut: MeasuredCut, sensor: ToolSensor, limits: bool = True
) -> Recording:
    """The cut by the nominal robot. Raises ImplausibleError for one that it could not have made;
    limits: of how far it may be from the nominal robot's motors and tool."""
    for name in ("reference", "correction", "motor_angle", "motor_torque"):
        if not np.isfinite(getattr(cut, name)).all():
            raise ImplausibleError(f"{cut.name}: {name} holds values that are not finite")
    on = cut.moving
    if not on.any():
        raise ImplausibleError(f"{cut.name}: the reference never moves")
    error = np.abs(cut.motor_angle - cut.reference - cut.correction).max(axis=0)
    axis = int(error.argmax())
    if limits and error[axis] > _LARGEST_ERROR:
        raise ImplausibleError(
            f"{cut.name}: motor {axis + 1} is up to {error[axis]:.3g} rad from its reference: "
            "another robot, or another unit"
        )
    sensor.check(design.model, cut, limits)
    run = design.run([Individual()], cut.reference, cut.correction)[0]
    nominal = run.motor_torque[on]
    gain = float(np.vdot(nominal, cut.motor_torque[on]) / np.vdot(nominal, nominal))
    low, high = _TORQUE_GAIN
    if not low < gain < high:
        raise ImplausibleError(
            f"{cut.name}: motor_torque is {gain:.3g} times that of the nominal robot; "
            "it must be in N m of the motor, before the gear"
        )
    return run


def sensor_of(cut: MeasuredCut, measure: SensorName) -> SensorName:
    """What a cut is identified from: the scan of it, if there is one."""
    return measure if cut.scan is None else "scan"


def _check_outlier(left: Sequence[tuple[str, float]], sensor: ToolSensor) -> None:
    """Raise ImplausibleError for a cut whose held-out residual is far above those of the others."""
    if len(left) < 3:
        return
    name, worst = max(left, key=lambda each: each[1])
    usual = float(np.median([each for _, each in left]))
    if worst > max(sensor.unsuspicious, _OUTLIER * usual):
        raise ImplausibleError(
            f"{name} contradicts the other cuts: a twin of those leaves "
            f"{sensor.factor * worst:.3g} {sensor.unit} of the {sensor.quantity}, "
            f"{sensor.factor * usual:.3g} is usual; leave it out, or cut it again"
        )


_FEWEST, _UNEXPLAINED, _BETTER = 4, 30e-6, 0.5
"""Cuts by a tracker, and their held-out residual [m], from which on hysteresis of the gears is
identified too, and what it must leave of that residual. With hysteresis physics takes four times as
long. Individual 8000 leaves 5 um, 81 with hysteresis, and 16 where that is identified. ESTIMATES"""


def _held_out(found: IdentifiedParameters) -> float:
    return float(np.median(found.held_out))


@dataclass(frozen=True, eq=False)
class CommissionedTwin:
    """A twin, and what its identification says of itself."""

    twin: Twin
    identified: IdentifiedParameters


def commission(
    cuts: Sequence[MeasuredCut],
    *,
    robot: str = "large",
    payload: float | None = None,
    measure: SensorName = "tracker",
    cfg: Identification = Identification(),
    checked: bool = True,
    progress: Callable[[], None] = lambda: None,
) -> CommissionedTwin:
    """Identify the individual that made these cuts.

    Args:
        robot: name of the cell.
        payload: mass of its tool [kg]; that of the robot's file if None.
        measure: sensor of the tool; cuts that a scan was made of are identified from that.
        checked: motors and tool are held against the nominal robot, and recordings against each
            other, within limits for cuts: not for long motions, or a tool that is heavier than that
            of its file. Always: values are finite, the reference moves, torques are in N m.
        progress: called after each cut of each step.

    Raises:
        ImplausibleError: a recording that cannot be of this robot, or that contradicts the others;
            it is named.
    """
    if not cuts:
        raise ValueError("commissioning needs one recorded cut or more")
    names: set[SensorName] = {sensor_of(cut, measure) for cut in cuts}
    if names == {"tracker", "scan"}:
        raise ValueError("a coupon goes with cuts by an IMU, or alone, not with those of a tracker")
    design = design_of(robot, payload)
    sensors = [SENSORS[sensor_of(cut, measure)] for cut in cuts]
    nominal = [
        checked_against(design, cut, sensor, checked)
        for cut, sensor in zip(cuts, sensors, strict=True)
    ]
    hysteresis, servo = False, own_servo(design, cuts, nominal)
    design = design.besides(servo)
    kinds = sensors if len({id(sensor) for sensor in sensors}) > 1 else sensors[0]
    found = identify(design, cuts, cfg, progress, sensor=kinds)
    if servo is not None:
        individual = parameters_of(design).individual(found.theta, gear_phases(design.model))
        servo = refined(servo, design, individual, cuts)
        found = identify(design := design.besides(servo), cuts, cfg, progress, sensor=kinds)
    if names == {"tracker"} and len(cuts) >= _FEWEST and _held_out(found) > _UNEXPLAINED:
        other = identify(design.besides(servo, True), cuts, cfg, progress, sensor=kinds)
        if hysteresis := _held_out(other) < _BETTER * _held_out(found):
            found = other
    for sensor in (SENSORS[name] for name in SENSORS) if checked else ():
        _check_outlier(
            [
                (cut.name, left)
                for cut, own, left in zip(cuts, sensors, found.held_out, strict=True)
                if own is sensor
            ],
            sensor,
        )
    twin = Twin(
        robot=robot,
        digest=robot_digest(robot),
        payload=payload,
        servo=servo,
        hysteresis=hysteresis,
        sensor="imu and scan" if names == {"imu", "scan"} else names.pop(),
        theta=found.theta,
        covariance=found.covariance,
        held_out=found.held_out * [sensor.displacement for sensor in sensors],
        torque_residual=np.sqrt(np.mean(found.torque**2, axis=0)),
        names=tuple(cut.name for cut in cuts),
    )
    return CommissionedTwin(twin, found)
