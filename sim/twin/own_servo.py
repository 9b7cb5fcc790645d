"""A servo that is not the type's, as the motors of recorded cuts show it.

What the controller adds to the set points on their way to the motors is taken for a filter that all
axes share, and a friction feedforward for one factor of Coulomb friction:

    added(t) = sum_k h_k (s(t - k T) - s(0))        s = reference + correction, T = `LOG_PERIOD`

and feedforwards of inertia and gravity for one factor of the rigid torque. Least squares over all
axes of the motors' deviation from those of a run that knows no such servo, in a few steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array, real_array

from ..robot.drives import FRICTION_SPEED, Drives, OwnDrive
from ..robot.individual import Individual
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from .recordings import MeasuredCut
from .simulation import RobotDesign, motor_path

TAPS = 25
"""K: 0.1 s. More leave no less, with a notch at 11 Hz."""
EXPLAINED = 0.8
"""Of the power of the motors' deviation, above which a servo is not the type's. Of individual 8000
a notch and a feedforward of its own explain 0.998, the other effects of `alien` at most 0.17, and
the friction of individuals 1001 to 1008 at most 0.26; four cuts each."""
_LARGEST = 2.0
"""Of what a servo adds, over its set points. ESTIMATE"""
_STEPS = 3
"""Of the least squares: a fourth leaves hardly less of individual 8036."""
_RIDGE = 1e-6
"""Of the normalised least squares."""


@dataclass(frozen=True, eq=False)
class OwnServo(OwnDrive):
    """What a servo does beyond the type's."""

    response: Array
    """(K,), h."""
    friction: float
    inertia: float
    """Of Coulomb friction, and of the change of the rigid torque, what is fed forward beyond the
    type's."""

    @classmethod
    def of(cls, response: Sequence[float], friction: float, inertia: float) -> "OwnServo":
        """The servo of `content`."""
        return cls(real_array("response", response), float(friction), float(inertia))

    def content(self) -> dict[str, Any]:
        """As plain values."""
        return self.__dict__ | {"response": self.response.tolist()}

    def nonsense(self) -> str | None:
        """Why this is no servo; None if it is."""
        values = np.append(self.response, (self.friction, self.inertia))
        if self.response.shape != (TAPS,) or not (np.abs(values) <= _LARGEST).all():
            return f"servo must have {TAPS} values and two factors, all within {_LARGEST:g}"
        return None

    def applied(self, drives: Drives, load: Array, velocity: Array, time: Array) -> None:
        """Nothing."""

    def feedforward(self, drives: Drives, torque: Array, velocity: Array) -> Array:
        more = self.friction * _coulomb(drives, velocity)
        return torque + more + self.inertia * (torque - torque[0])

    def commands(self, controls: Array, step: float) -> Array:
        moved, out = controls[:, :, :2] - controls[0, :, :2], controls.copy()
        for k, part in enumerate(self.response):
            late = min(round(k * LOG_PERIOD / step), len(moved))
            out[late:, :, :2] += part * moved[: len(moved) - late]
        return out


def _coulomb(drives: Drives, velocity: Array) -> Array:
    """(M, n) [N m], arm side, at velocity (M, n) [rad/s]."""
    return drives.coulomb_friction * drives.gear * np.tanh(velocity / FRICTION_SPEED)


def own_servo(
    design: RobotDesign, cuts: Sequence[MeasuredCut], nominal: Sequence[Recording]
) -> OwnServo | None:
    """The servo of recorded cuts, which the nominal robot made too; None where it is the type's."""
    columns = [_columns(design, cut) for cut in cuts]
    found, explained = _added(columns, cuts, nominal)
    return _refined(found, design, Individual(), cuts, columns) if explained > EXPLAINED else None


def refined(
    servo: OwnServo, design: RobotDesign, individual: Individual, cuts: Sequence[MeasuredCut]
) -> OwnServo:
    """The servo with what it adds beyond that of an individual that made the cuts."""
    return _refined(servo, design, individual, cuts, [_columns(design, cut) for cut in cuts])


def _refined(
    servo: OwnServo,
    design: RobotDesign,
    individual: Individual,
    cuts: Sequence[MeasuredCut],
    columns: Sequence[Array],
) -> OwnServo:
    for _ in range(_STEPS):
        known = design.besides(servo)
        runs = [known.run([individual], cut.reference, cut.correction)[0] for cut in cuts]
        more, _ = _added(columns, cuts, runs)
        servo = OwnServo(
            servo.response + more.response,
            servo.friction + more.friction,
            servo.inertia + more.inertia,
        )
    return servo


def _added(
    columns: Sequence[Array], cuts: Sequence[MeasuredCut], runs: Sequence[Recording]
) -> tuple[OwnServo, float]:
    """What a servo adds beyond that of runs of the same cuts, and the part of the power of the
    motors' deviation that it explains."""
    left = [cut.motor_angle - motor_path(run) for cut, run in zip(cuts, runs, strict=True)]
    A, b = np.concatenate(columns), np.concatenate([(each - each[0]).T.ravel() for each in left])
    size = np.sqrt(np.mean(A**2, axis=0))
    A = A / size
    found = np.linalg.solve(A.T @ A + _RIDGE * len(b) * np.eye(len(size)), A.T @ b)
    *response, friction, inertia = found / size
    explained = 1.0 - float(np.sum((b - A @ found) ** 2) / np.sum(b**2))
    return OwnServo(np.array(response), float(friction), float(inertia)), explained


def _columns(design: RobotDesign, cut: MeasuredCut) -> Array:
    """(n N, K + 2), axis by axis: set points some samples late, and how far the servo gives way to
    torques of Coulomb friction and of inertia."""
    from scipy.signal import bilinear, lfilter

    drives, moved = design.model.drives, cut.reference + cut.correction
    asked = design.commanded(cut.reference)
    every = (len(asked.torque) - 1) // (len(moved) - 1)
    rigid = (asked.torque - asked.torque[0])[::every]
    velocity = np.gradient(moved, LOG_PERIOD, axis=0)
    moved, coulomb, n = moved - moved[0], _coulomb(drives, velocity), len(moved)
    each = []
    for axis, gear in enumerate(drives.gear):
        late = [np.append(np.zeros(k), moved[:, axis])[:n] for k in range(TAPS)]
        gains = drives.kd[axis], drives.kp[axis], drives.ki[axis]
        b, a = bilinear([1.0, 0.0], gains, fs=1.0 / LOG_PERIOD)
        torques = np.column_stack((coulomb[:, axis], rigid[:, axis])) / gear**2
        each.append(np.column_stack((*late, lfilter(b, a, torques, axis=0))))
    return np.concatenate(each)
