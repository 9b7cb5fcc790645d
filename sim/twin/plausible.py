"""Checks of recorded cuts against the nominal robot, before anything is identified from them."""

import numpy as np

from armside.arrays import Array

from ..records.files import InputError
from ..robot.individual import Individual
from .measured import MeasuredCut
from .simulation import Design
from .tool_sensor import ToolSensor

_LARGEST_ERROR = 0.02
"""[rad], of a motor from its reference: ten times what a cut at full speed shows. ESTIMATE."""
_TORQUE_GAIN = 0.6, 1.6
"""Measured torque over that of the nominal robot, least squares over all axes. Friction differs by
a third between robots, units by more. ESTIMATE."""


class ImplausibleError(InputError):
    """A recording that cannot be of this robot, or not in the stated units."""


def check(design: Design, cut: MeasuredCut, sensor: ToolSensor) -> None:
    """Raise ImplausibleError for a cut that the nominal robot could not have made."""
    _check_numbers(cut)
    _check_motors(cut)
    sensor.check(design.model, cut)
    _check_torque(cut, design.run([Individual()], cut.reference, cut.correction)[0].motor_torque)


def _check_numbers(cut: MeasuredCut) -> None:
    for name in ("reference", "correction", "motor_angle", "motor_torque"):
        if not np.isfinite(getattr(cut, name)).all():
            raise ImplausibleError(f"{cut.name}: {name} holds values that are not finite")


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
