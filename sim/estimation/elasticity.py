"""Springs in an arm: gears with lost motion, and the structure in series; as one unknown vector.

    theta = (log stiffness of gears and structure (n) | log damping of gears, of the structure |
             lost motion | clock | log process noise | mounting (3))

Stiffnesses, damping and lost motion are relative to the nominal arm. One factor serves the lost
motion of all gears, which a data sheet states for the type: 1 + z, at least 0. On disk, parameters
are the entry `springs` of the summary of `armside identify`.
"""

import json
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..records.files import InputError, check_file
from ..robot.effects import Effect, available
from ..robot.mjcf import numeric
from ..robot.model import RobotModel
from .arm_filter import FRACTION
from .nominal import NominalArm

_RIGID = 1e3  # stiffness of a structure that is not known to give way, over that of the gear beside


@dataclass(frozen=True, eq=False)
class Elasticity:
    """n elastic degrees of freedom, a of them gears."""

    stiffness: Array
    """(n,) [N m/rad], of the wound gear and of the structure."""
    damping: Array
    """(n,) [N m s/rad]."""
    axes: np.ndarray
    """(a,) the gears among them."""
    softening: Array
    """(n,) in [0, 1): fraction of the stiffness that is missing within the lost motion."""
    lost_motion: Array
    """(n,) [rad], half width of the soft range."""

    def scaled(
        self, stiffness: Array, gear_damping: float, structure_damping: float, lost_motion: float
    ) -> "Elasticity":
        """With factors on stiffness (n,), damping, and the width of the soft range."""
        damping = np.full(len(self.damping), structure_damping)
        damping[self.axes] = gear_damping
        return replace(
            self,
            stiffness=self.stiffness * stiffness,
            damping=self.damping * damping,
            lost_motion=self.lost_motion * lost_motion,
        )

    @property
    def on_rigid_structure(self) -> "Elasticity":
        """The gears alone: what stands in series with them gives way by a thousandth of them."""
        rigid = np.full(len(self.stiffness), _RIGID)
        rigid[self.axes] = 1.0
        return self.scaled(rigid, 1.0, 1.0, 1.0)

    def mean_slope(self, angle: Array) -> "Elasticity":
        """Linear springs for deflections (M, n): within its lost motion a gear is soft."""
        inside = (np.abs(angle) < self.lost_motion).mean(axis=0)
        return replace(self, stiffness=self.stiffness * (1.0 - inside * self.softening))


def nominal_elasticity(robot: RobotModel, arm: NominalArm) -> Elasticity:
    """Assumed gears of an arm, its structure, and the lost motion that the robot's file states."""
    mj, n, joints = arm.mj, arm.n_free, arm.motion.joints
    stiffness, damping = mj.jnt_stiffness.ravel()[joints], mj.dof_damping.ravel()[joints]
    stiffness[arm.axes], damping[arm.axes] = arm.stiffness, arm.damping
    softening, lost = np.zeros(n), np.zeros(n)
    if Effect.LOST_MOTION in available(robot):
        a = robot.n_axes
        whole = [float(robot.mj.joint(f"flex_{i + 1}").stiffness.flat[0]) for i in range(a)]
        softening[arm.axes] = 1.0 - numeric(robot.mj, "gear_soft_stiffness", a) / whole
        lost[arm.axes] = numeric(robot.mj, "gear_lost_motion", a)
    return Elasticity(stiffness, damping, arm.axes, softening, lost)


@dataclass(frozen=True, kw_only=True)
class SpringPrior:
    """Standard deviations around the nominal arm."""

    gears: float = 0.2
    """Log stiffness: uniform within +- 30 % is a standard deviation of 0.17."""
    structure: float = 0.7
    """Log stiffness of bearings and links: within a factor of two of the gear beside. ESTIMATE"""
    damping: float = 0.5
    lost_motion: float = 0.3
    """Of its width, relative. ESTIMATE"""
    clock: float = 0.010
    """[s]."""
    process_noise: float = 0.5
    mounting: float = 0.02
    """[rad], rotation of the IMU's housing about each of its axes."""

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) > 0.0:
                raise ValueError(f"{field.name} must be > 0, got {getattr(self, field.name)}")

    def standard_deviation(self, springs: Elasticity) -> Array:
        """(m,), of theta; its mean is 0."""
        stiffness = np.full(len(springs.stiffness), self.structure)
        stiffness[springs.axes] = self.gears
        others = self.damping, self.damping, self.lost_motion, self.clock, self.process_noise
        return np.concatenate([stiffness, others, np.full(3, self.mounting)])


def names(springs: Elasticity) -> tuple[str, ...]:
    """(m,), of the entries of theta."""
    gear = {int(dof): i + 1 for i, dof in enumerate(springs.axes)}
    stiffness, before, count = list[str](), 0, 0
    for dof in range(len(springs.stiffness)):
        before, count = (gear[dof], 0) if dof in gear else (before, count + 1)
        stiffness.append(f"stiffness {before}" + (f" across {count}" if count else ""))
    damping = "damping", "damping of the structure"
    mounting = (f"mounting {axis}" for axis in "xyz")
    return (*stiffness, *damping, "lost motion", "clock", "process noise", *mounting)


@dataclass(frozen=True, eq=False)
class ArmParameters:
    """Springs of an arm, and clock and mounting of its IMU."""

    springs: Elasticity
    clock_offset: float
    """Robot time when the unit's clock shows 0 [s]."""
    process_noise: float
    """Fraction of the arm's twist that the model leaves unexplained, as `arm_filter.FRACTION`."""
    mounting: Array
    """(3,) [rad], rotation of the IMU's housing from its site."""


def parameters_at(nominal: Elasticity, theta: Array) -> ArmParameters:
    """Parameters of a vector."""
    n = len(nominal.stiffness)
    gears, structure, lost, clock, noise = theta[n : n + 5]
    width = max(0.0, 1.0 + float(lost))
    damped = float(np.exp(gears)), float(np.exp(structure))
    springs = nominal.scaled(np.exp(theta[:n]), *damped, width)
    return ArmParameters(springs, float(clock), FRACTION * float(np.exp(noise)), theta[n + 5 :])


_OF_SPRINGS = ("stiffness", "damping", "softening", "lost_motion")
"""Entries with a number for each spring, of gears and structure."""
_KEYS = (*_OF_SPRINGS, "gears", "clock_offset", "process_noise", "mounting")


def springs_entry(known: ArmParameters) -> dict[str, Any]:
    """Parameters as an entry of a summary."""
    springs = {name: getattr(known.springs, name) for name in _OF_SPRINGS}
    unit = {name: getattr(known, name) for name in ("clock_offset", "process_noise", "mounting")}
    return {**springs, "gears": known.springs.axes, **unit}


def read_parameters(folder: Path, robot: str, n_axes: int = 6) -> ArmParameters:
    """Parameters from a folder of `armside identify`.

    Place, payload and IMU may be others: springs are the robot's, inertia is known, and clocks are
    found again.

    Raises InputError: there are none, entries are missing or wrong, or the robot is another.
    """
    file = folder / "summary.json"
    try:
        stored = json.loads(check_file(file).read_text(encoding="utf-8"))
        springs, known = stored["springs"], str(stored["config"]["robot"])
        missing = [name for name in _KEYS if name not in springs]
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{folder} holds no identification of armside identify") from error
    if known != robot:
        raise InputError(f"{folder} was identified on robot {known}, not on {robot}")
    if missing:
        raise InputError(f"{file}: springs lack {', '.join(missing)}; identify again")
    n = len(springs["stiffness"]) if isinstance(springs["stiffness"], list) else 0
    K, D, soft, lost = (_array(springs, name, (n,), file) for name in _OF_SPRINGS)
    axes = _array(springs, "gears", (n_axes,), file)
    whole = np.isin(axes, np.arange(n)).all() and (np.diff(np.sort(axes)) > 0.0).all()
    if not (whole and (K > 0.0).all() and (D >= 0.0).all()):
        raise InputError(f"{file}: springs must be stiffer than 0, with one for each gear")
    clock, noise = (float(_array(springs, name, (), file)) for name in _KEYS[5:7])
    if not noise > 0.0:
        raise InputError(f"{file}: springs.process_noise must be > 0, got {noise:g}")
    elastic = Elasticity(K, D, axes.astype(int), soft, lost)
    return ArmParameters(elastic, clock, noise, _array(springs, "mounting", (3,), file))


def _array(stored: dict[str, Any], name: str, shape: tuple[int, ...], file: Path) -> Array:
    """An entry of that shape. Raises InputError for anything else."""
    try:
        value = np.array(stored[name], dtype=np.float64)
    except (ValueError, TypeError):
        value = np.array(np.nan)
    if value.shape != shape or not np.isfinite(value).all():
        raise InputError(f"{file}: springs.{name} must be numbers of shape {shape}")
    return value
