"""Limits of guided motion, checked by the client before it sends and by the controller each cycle.

A target must be within the ranges of the joints, no further from the last one than the speed
limit allows, and slow enough near the end of a range to stop before it.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from armside.arrays import Array, check_numbers
from armside.kinematics import Limits

if TYPE_CHECKING:
    from ..cell import Cell
    from ..robot.model import RobotModel

STOPPING_TIME = 0.2
"""[s], in which a joint stops from its highest speed. ESTIMATE: stop category 1 of such arms takes
0.2 to 0.5 s."""
ROUNDING = 1e-9
"""Relative, by which a step may exceed the speed limit."""


@dataclass(frozen=True, kw_only=True)
class GuidanceLimits:
    """Limits of the motor angles (n,), arm side."""

    lower: Array
    upper: Array
    """[rad]."""
    speed: Array
    """[rad/s]."""
    correction: float = np.deg2rad(5.0)
    """Largest correction of a program [rad]. KUKA's AXISCORR has 5 degrees by default."""
    period: float = 0.004
    """[s]."""
    joints: Limits | None = None
    """Ranges of sums of motor angles beside those of each."""

    def __post_init__(self) -> None:
        check_numbers(self, "lower", "upper", "speed", several=True)
        check_numbers(self, "correction", "period")
        shapes = {np.shape(each) for each in (self.lower, self.upper, self.speed)}
        if len(shapes) > 1:
            raise ValueError(f"lower, upper and speed must have one shape (n,), got {shapes}")

    @classmethod
    def of_cell(cls, cell: "Cell") -> "GuidanceLimits":
        """Limits of a cell alone."""
        of = cell.limits
        lower, upper, speed = map(np.array, (of.lower, of.upper, of.speed))
        return cls(lower=lower, upper=upper, speed=speed, joints=of)

    @classmethod
    def of(cls, model: "RobotModel", cell: "Cell | None" = None) -> "GuidanceLimits":
        """Limits of a robot's model, and those of its cell where they are narrower."""
        (lower, upper), speed = model.joint_range.T, model.drives.speed_limit
        if cell is None:
            return cls(lower=lower, upper=upper, speed=speed)
        own = cls.of_cell(cell)
        lower, upper = np.maximum(lower, own.lower), np.minimum(upper, own.upper)
        return replace(own, lower=lower, upper=upper, speed=np.minimum(speed, own.speed))

    def refusal(self, target: Array, before: Array) -> str | None:
        """Why a target (n,) [rad] is refused that follows `before`; None if it is allowed."""
        if target.shape != before.shape:
            return f"needs {len(before)} axes, got {target.size}"
        if not np.isfinite(target).all():
            return "holds values that are not finite"
        return self.out_of_range(target) or self.too_fast(target, before)

    def out_of_range(self, target: Array) -> str | None:
        """Why a target (n,) [rad] is outside the ranges; None if it is inside."""
        if (axis := _first((target < self.lower) | (target > self.upper))) is not None:
            low, high = np.rad2deg((self.lower[axis], self.upper[axis]))
            got = np.rad2deg(target[axis])
            return f"axis {axis + 1} must be {low:.6g} to {high:.6g} deg, got {got:.6g}"
        if self.joints is not None and not self.joints.contain(target):
            return "is outside the range of coupled axes"
        return None

    def too_fast(self, target: Array, before: Array) -> str | None:
        """Why a target (n,) [rad] is too far from `before`, a period ago; None if it is not."""
        speed = (target - before) / self.period
        room = np.where(speed > 0.0, self.upper - target, target - self.lower)
        stopping = np.sqrt(2.0 * self.speed / STOPPING_TIME * np.maximum(room, 0.0))
        allowed = np.minimum(self.speed, stopping)
        if (axis := _first(np.abs(speed) > allowed * (1.0 + ROUNDING) + 1e-9)) is not None:
            got, most = np.rad2deg((abs(speed[axis]), allowed[axis]))
            return f"axis {axis + 1} must be at most {most:.6g} deg/s fast here, got {got:.6g}"
        return None

    def correction_refusal(self, correction: Array) -> str | None:
        """Why a correction (n,) [rad] of a program is refused; None if it is allowed."""
        if (axis := _first(~(np.abs(correction) <= self.correction))) is not None:
            most, got = np.rad2deg((self.correction, correction[axis]))
            return f"the correction of axis {axis + 1} must be within {most:.6g} deg, got {got:.6g}"
        return None


def _first(wrong: np.ndarray) -> int | None:
    return int(np.argmax(wrong)) if wrong.any() else None
