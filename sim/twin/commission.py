"""Commissioning of a twin: recorded cuts are checked against the nominal robot, and identified."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..robot.individual import Individual
from .identification import Identification, IdentifiedParameters, identify
from .imu_sensor import IMU
from .recordings import ImplausibleError, MeasuredCut, SensorName
from .simulation import RobotDesign, design_of, robot_digest
from .tool_sensor import TRACKER, ToolSensor
from .twin import Twin

SENSORS: Mapping[SensorName, ToolSensor] = {"tracker": TRACKER, "imu": IMU}

_LARGEST_ERROR = 0.02
"""[rad], of a motor from its reference: ten times what a cut at full speed shows. ESTIMATE."""
_TORQUE_GAIN = 0.6, 1.6
"""Measured torque over that of the nominal robot, least squares over all axes. Friction differs by
a third between robots, units by more. ESTIMATE."""
_OUTLIER = 5.0
"""Held-out residual of a cut over the median of all, above which it is called corrupt. ESTIMATE."""


def check(design: RobotDesign, cut: MeasuredCut, sensor: ToolSensor) -> None:
    """Raise ImplausibleError for a cut that the nominal robot could not have made."""
    for name in ("reference", "correction", "motor_angle", "motor_torque"):
        if not np.isfinite(getattr(cut, name)).all():
            raise ImplausibleError(f"{cut.name}: {name} holds values that are not finite")
    _check_motors(cut)
    sensor.check(design.model, cut)
    _check_torque(cut, design.run([Individual()], cut.reference, cut.correction)[0].motor_torque)


def _check_motors(cut: MeasuredCut) -> None:
    if not cut.moving.any():
        raise ImplausibleError(f"{cut.name}: the reference never moves")
    error = np.abs(cut.motor_angle - cut.reference - cut.correction).max(axis=0)
    axis = int(error.argmax())
    if error[axis] > _LARGEST_ERROR:
        raise ImplausibleError(
            f"{cut.name}: motor {axis + 1} is up to {error[axis]:.3g} rad from its reference: "
            "another robot, or another unit"
        )


def _check_torque(cut: MeasuredCut, nominal: Array) -> None:
    """nominal: (N, 6) [N m], of the nominal robot with the same reference."""
    on = cut.moving
    nominal = nominal[on]
    gain = float(np.vdot(nominal, cut.motor_torque[on]) / np.vdot(nominal, nominal))
    low, high = _TORQUE_GAIN
    if not low < gain < high:
        raise ImplausibleError(
            f"{cut.name}: motor_torque is {gain:.3g} times that of the nominal robot; "
            "it must be in N m of the motor, before the gear"
        )


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
    progress: Callable[[], None] = lambda: None,
) -> CommissionedTwin:
    """Identify the individual that made these cuts.

    Args:
        robot: name of the cell.
        payload: mass of its tool [kg]; that of the robot's file if None.
        measure: sensor of the tool.
        progress: called after each cut of each step.

    Raises:
        ImplausibleError: a recording that cannot be of this robot, or that contradicts the others;
            it is named.
    """
    if not cuts:
        raise ValueError("commissioning needs one recorded cut or more")
    design, sensor = design_of(robot, payload), SENSORS[measure]
    for cut in cuts:
        check(design, cut, sensor)
    found = identify(design, cuts, cfg, progress, sensor=sensor)
    _check_agreement(cuts, found, sensor)
    twin = Twin(
        robot=robot,
        digest=robot_digest(robot),
        payload=payload,
        sensor=measure,
        theta=found.theta,
        covariance=found.covariance,
        held_out=sensor.displacement * found.quality.held_out,
        torque_residual=np.sqrt(np.mean(found.quality.torque**2, axis=0)),
        names=tuple(cut.name for cut in cuts),
    )
    return CommissionedTwin(twin, found)


def _check_agreement(
    cuts: Sequence[MeasuredCut], found: IdentifiedParameters, sensor: ToolSensor
) -> None:
    """Raise ImplausibleError for a cut that the twin of the others does not explain at all."""
    left = found.quality.held_out
    worst = int(np.nan_to_num(left).argmax())
    usual = float(np.median(left))
    if len(cuts) > 2 and left[worst] > max(sensor.unsuspicious, _OUTLIER * usual):
        much, little = sensor.factor * left[worst], sensor.factor * usual
        raise ImplausibleError(
            f"{cuts[worst].name} contradicts the other cuts: a twin of those leaves "
            f"{much:.3g} {sensor.unit} of the {sensor.quantity}, {little:.3g} is usual; leave it "
            "out, or cut it again"
        )
