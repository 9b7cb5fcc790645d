"""Scan of a coupon as the sensor of identification: deviations across each contour.

    residual = d_scan(s) - n(s)^T (tool - J dphi - contour)      s: foot of the tool on the contour

n is the normal of the drawn contour; the tool is that of the twin in base axes, moved by what the
motor angles of record and simulation differ. A contour that is cut a millimetre from its place has
deviations that are not linear in it. So both, the scanned and the simulated contour, are first
fitted to the drawn one by a rigid motion; what these motions differ by is linear, and added.

Of the sheet nothing is known but its drawing: its placement, scale and skew of the scanner, half
the beam, and a kerf that differs between the two directions or from contour to contour are unknown
parameters beside those of the robot.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from armside.arrays import Array

from ..motion.contour import outward_normal
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from ..scan.shape import Shape, scanned_shape, shape, taken_off, usable
from .parameters import Block
from .recordings import ImplausibleError, MeasuredCut, ScannedCut
from .simulation import motor_path
from .tool_sensor import ToolSensor, gear_waves, jacobians, rigid_path

_PLACE, _TURN = 10e-3, 10e-3
"""[m], [rad], of the sheet from where the robot's base has it. ESTIMATE."""
_BEAM, _MEASURED_BEAM = 5e-6, 2e-6
"""[m], of half the diameter: assumed, and by an open kerf. ESTIMATE."""
_APART = 2e-3
"""[m], of the motors' path from the contour, beyond which it is of another. ESTIMATE: a robot that
is not corrected leaves a circle of 15 mm at 100 mm/s by 1.05 mm, a slot by 1.08."""
_DIRECTION, _FROM_CUT_TO_CUT = 15e-6, 5e-6
"""[m], of half the kerf: clockwise less counter-clockwise, and of each contour. ESTIMATE."""


def sheet_blocks(cut: MeasuredCut) -> tuple[Block, ...]:
    """What is unknown of the sheet that a cut is on, and of its scan."""
    assert cut.scan is not None
    seen = cut.scan
    return (
        Block("sheet_place", (2,), _PLACE),
        Block("sheet_turn", (1,), _TURN),
        Block("sheet_scale", (2,), seen.scale),
        Block("sheet_skew", (1,), 0.5 * seen.scale),
        Block("sheet_beam", (1,), _MEASURED_BEAM if seen.beam_measured else _BEAM),
        Block("sheet_direction", (1,), _DIRECTION),
        Block("sheet_kerf", (seen.count,), _FROM_CUT_TO_CUT),
    )


def check_scanned(model: RobotModel, cut: MeasuredCut, against_nominal: bool = True) -> None:
    """Raise ImplausibleError for a cut without a scan, or one that is of something else."""
    if cut.scan is None:
        raise ImplausibleError(f"{cut.name} is not on the scanned sheet")
    comparison = ScanComparison(model, cut)
    if (objection := comparison.scanned.objection) is not None:
        raise ImplausibleError(f"{cut.name}: {objection}: another contour, or another unit")
    if (apart := comparison.motors_apart) > _APART:
        raise ImplausibleError(
            f"{cut.name}: the motors' path lies {1e3 * apart:.3g} mm from its contour after "
            f"placement, more than {1e3 * _APART:g} mm: the record is of another"
        )
    if len(comparison.rows) < 3:
        raise ImplausibleError(f"{cut.name}: the scan has no place where the beam was on")


@dataclass(frozen=True, eq=False)
class ScanComparison:
    """See `CutComparison`; one column, deviation across the contour [m], at samples of the log."""

    model: RobotModel
    cut: MeasuredCut

    @property
    def seen(self) -> ScannedCut:
        assert self.cut.scan is not None
        return self.cut.scan

    @cached_property
    def scanned(self) -> Shape:
        """The scanned contour."""
        return scanned_shape(self.seen.curve, self.seen.contour)

    @cached_property
    def _on(self) -> np.ndarray:
        """Samples of the log on the contour."""
        first, last = self.seen.contour_time
        time = np.arange(len(self.cut.motor_angle)) * LOG_PERIOD
        return np.flatnonzero((time >= first) & (time < last))

    @cached_property
    def rows(self) -> np.ndarray:
        """Of the samples on the contour those whose foot the scan has seen, by the motors' path
        fitted to the contour; its ends are held out."""
        return np.flatnonzero(usable(self.seen.curve, self.scanned, self._foot))

    @cached_property
    def _motors(self) -> Shape:
        path = rigid_path(self.model, self.cut.motor_angle[self._on])
        return shape(self.seen.curve, self._in_plane(path))

    @property
    def motors_apart(self) -> float:
        """Largest distance [m] of the motors' path from the contour, after it is fitted to it."""
        return float(np.abs(self._motors.deviation).max())

    @property
    def _foot(self) -> Array:
        return self._motors.arc_length

    @cached_property
    def _normal(self) -> Array:
        """(K, 3), of the contour at the rows, base axes."""
        normal = outward_normal(self.seen.curve.tangent(self._foot[self.rows]))
        return normal @ self.seen.plane.axes[:, :2].T

    @cached_property
    def _kinematics(self) -> tuple[Array, Array]:
        return jacobians(self.model, self.cut.motor_angle[self._on[self.rows]])

    def residual(self, run: Recording) -> Array:
        curve, scanned = self.seen.curve, self.scanned
        J = jacobians(self.model, self.cut.motor_angle[self._on])[0]
        moved = np.einsum("kij,kj->ki", J, (self.cut.motor_angle - motor_path(run))[self._on])
        made = shape(curve, self._in_plane(_tool(run)[self._on] + moved))
        s, apart = self._foot[self.rows], scanned.motion - made.motion
        left = scanned.at(s, curve.length) - made.at(s, curve.length)
        return (left + taken_off(curve, s) @ apart)[:, None]

    def change(self, base: Recording, run: Recording) -> Array:
        on = self._on[self.rows]
        moved = (motor_path(run) - motor_path(base))[on]
        beyond = (_tool(run) - _tool(base))[on] - np.einsum(
            "kij,kj->ki", self._kinematics[0], moved
        )
        return self._across(beyond)

    def by_kinematics(self) -> Mapping[str, Array]:
        jacobian, geometry = self._kinematics
        waves = gear_waves(self.model, self.cut.motor_angle[self._on[self.rows]])
        errors = jacobian[:, :, :, None, None] * waves[:, None]
        position, orientation = np.split(self._across(geometry), 2, axis=2)
        return {
            "gear_error": self._across(errors.reshape(*jacobian.shape[:2], -1)),
            "position": position,
            "orientation": orientation,
            **self._of_sheet(),
        }

    def _of_sheet(self) -> Mapping[str, Array]:
        seen, s = self.seen, self._foot[self.rows]
        n, p = outward_normal(seen.curve.tangent(s)), seen.curve.point(s) + seen.middle
        one = np.ones((len(s), 1))
        columns = {
            "sheet_place": n,
            "sheet_turn": (p[:, 0] * n[:, 1] - p[:, 1] * n[:, 0])[:, None],
            "sheet_scale": n * p,
            "sheet_skew": (n[:, 0] * p[:, 1])[:, None],
            "sheet_beam": one,
            "sheet_direction": (0.5 if seen.clockwise else -0.5) * one,
            "sheet_kerf": one * np.eye(seen.count)[seen.number],
        }
        return {name: column[:, None, :] for name, column in columns.items()}

    def _across(self, vector: Array) -> Array:
        """(K, 1, ...) of vectors (K, 3, ...) in base axes."""
        return np.asarray(np.einsum("ki,ki...->k...", self._normal, vector))[:, None]

    def _in_plane(self, position: Array) -> Array:
        """(N, 2) [m] about the middle of the contour."""
        return self.seen.plane.from_base(position)[:, :2]


def _tool(run: Recording) -> Array:
    """(N, 3) [m], position of the tool in base axes at the instants of the log."""
    every = round(float(run.time[1] / run.truth.time[1]))
    return run.truth.tool_position[::every]


SCAN = ToolSensor(
    noise=8e-6,
    correlation=4.3,  # Edges of a cut are correlated over 3 mm, samples 0.16 mm apart at 40 mm/s.
    quantity="deviation across the contours",
    unit="µm",
    factor=1e6,
    displacement=1.0,
    unsuspicious=50e-6,
    check=check_scanned,
    comparison=ScanComparison,
    own=sheet_blocks,
)
"""Flatbed scan of a coupon; residuals are deviations [m]."""
