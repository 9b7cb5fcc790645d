"""The nominal arm of an estimator: links on springs whose other ends are the measured motors.

The motors are taken out of the robot's MJCF and with them everything that only moves them (rotors,
friction, servo): their angles are measured, so they are an input,

    M(q) q'' + c(q, q') + g(q) = K (phi - q) + D (phi' - q')

with q the arm's angles and phi the motor's, both on the arm side of the gear. This is the *nominal*
robot: `NominalCfg` sets its errors, and nothing is read from an individual.

The structure gives way in hinges of its own. A closed chain is reduced to its free joints.
"""

import copy
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..robot.drives import EXACT, GearError
from ..robot.flexibility import Flexibility, without
from ..robot.linkage import FreeMotion, free_joints
from ..robot.mjcf import ModelError
from ..robot.model import RobotModel, posture

_STREAM = 0xA2  # of assumed stiffnesses, apart from those of individual and instruments


@dataclass(frozen=True, kw_only=True)
class NominalCfg:
    """Assumed parameters of an arm, relative to the data of its file."""

    stiffness: float | tuple[float, ...] = 1.0
    """Factor on each gear's stiffness, or one for all."""
    damping: float = 1.0
    """Factor on the damping of all gears."""
    payload: float = 0.0
    """Added to the mass of the tool [kg]."""
    structure: bool = False
    """The hinges of the structure are known too."""

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping"):
            value = np.asarray(getattr(self, name))
            if not (np.isfinite(value).all() and (value > 0.0).all()):
                raise ValueError(f"factors of {name} must be > 0, got {value.tolist()}")


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalArm:
    """The model of `NominalCfg`, compiled, with its springs and indices."""

    mj: mujoco.MjModel
    """Actuators spring_1..n pull the axes towards the angles they are given."""
    axes: np.ndarray
    """(n,) each axis among the free joints."""
    stiffness: Array
    """(n,) [N m/rad]."""
    damping: Array
    """(n,) [N m s/rad]."""
    gear_error: GearError = EXACT
    """Known transmission error, as `armside gears` finds it; none as long as none is known."""

    def gear_output(self, motor_angle: Array) -> Array:
        """Outputs of the gears (M, n) [rad], which pull the springs, at motor angles (M, n)."""
        known = self.gear_error
        return motor_angle if known is EXACT else motor_angle + known(motor_angle)

    @cached_property
    def motion(self) -> FreeMotion:
        """Free joints, and how passive ones of closed chains follow them."""
        joints = free_joints(self.mj)
        follow = np.eye(self.mj.nv)[:, joints]
        follow[:, self.axes] = posture(self.mj, joints[self.axes])
        return FreeMotion(self.mj, follow)

    @property
    def n_free(self) -> int:
        """Free joints: the axes, and those of the structure if it is known."""
        return len(self.motion.joints)

    def with_springs(self, stiffness: ArrayLike, damping: ArrayLike) -> "NominalArm":
        """The same arm on other springs, (n,) each. Raises ValueError for another shape."""
        K, D = np.array(stiffness, dtype=np.float64), np.array(damping, dtype=np.float64)
        if K.shape != self.axes.shape:
            raise ValueError(f"stiffness must have shape {self.axes.shape}, got {K.shape}")
        mj = copy.copy(self.mj)
        springs = [mj.actuator(f"spring_{i + 1}").id for i in range(len(K))]
        mj.actuator_gainprm[springs, 0] = K
        mj.actuator_biasprm[springs, 1], mj.actuator_biasprm[springs, 2] = -K, -D
        return replace(self, mj=mj, stiffness=K, damping=D)


def nominal_arm(robot: RobotModel, cfg: NominalCfg = NominalCfg()) -> NominalArm:
    """Nominal arm of a robot loaded from its MJCF file, as the file has it: payload and all.

    Raises:
        ModelError: the robot's arm lacks a gear spring or the body of the tool, or has an equality
            that neither closes a chain nor is a brake.
    """
    spec = robot.parsed()
    for equality in list(spec.equalities):
        if equality.name.startswith("brake_"):  # holds motors
            spec.delete(equality)
        elif equality.type != mujoco.mjtEq.mjEQ_CONNECT:
            allowed = "an estimator takes brakes and connections of closed chains"
            raise ModelError(f"{allowed}, not the equality {equality.name!r}")
    numbers = range(1, robot.n_axes + 1)
    missing = [f"flex_{i}" for i in numbers if spec.joint(f"flex_{i}") is None]
    if missing:
        raise ModelError(f"the robot model lacks the joint {', '.join(missing)}")
    gears = [spec.joint(f"flex_{i}") for i in numbers]
    stiffness = np.array([np.ravel(gear.stiffness)[0] for gear in gears]) * cfg.stiffness
    damping = np.array([np.ravel(gear.damping)[0] for gear in gears]) * cfg.damping
    if not cfg.structure:
        without(spec, Flexibility.GEARS)
    _replace_motors_by_springs(spec, robot.n_axes)
    if cfg.payload:
        _reweigh(spec.body("tool"), cfg.payload)
    mj = spec.compile()
    gear_dofs = [int(mj.joint(f"flex_{i}").dofadr[0]) for i in numbers]
    axes = np.searchsorted(free_joints(mj), gear_dofs)
    arm = NominalArm(mj=mj, axes=axes, stiffness=stiffness, damping=damping)
    return arm.with_springs(stiffness, damping)


def _replace_motors_by_springs(spec: mujoco.MjSpec, n_axes: int) -> None:
    numbers = range(1, n_axes + 1)
    for i in numbers:
        spec.delete(spec.actuator(f"axis_{i}"))
        for what in ("pos", "torque"):
            spec.delete(spec.sensor(f"axis_{i}_{what}"))
    for tendon in [one for one in spec.tendons if one.name.startswith("gear_")]:
        spec.delete(tendon)
    for i in numbers:
        spec.delete(spec.joint(f"motor_{i}"))
        gear = spec.joint(f"flex_{i}")
        gear.stiffness, gear.damping = np.zeros_like(gear.stiffness), np.zeros_like(gear.damping)
        spring = spec.add_actuator(name=f"spring_{i}", target=gear.name)
        spring.trntype = mujoco.mjtTrn.mjTRN_JOINT
        spring.gaintype, spring.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE


def _reweigh(tool: mujoco.MjsBody | None, payload: float) -> None:
    """A payload of other mass and the same shape."""
    if tool is None:
        raise ModelError("the robot model lacks the body tool, which carries the payload")
    if tool.mass + payload < 0.0:
        change = f"{payload:+g} kg leaves less than nothing of its {tool.mass:g} kg"
        raise ValueError(f"the payload of the assumed arm must be >= 0 kg: {change}")
    tool.inertia = np.asarray(tool.inertia) * (1.0 + payload / tool.mass)
    tool.mass += payload


def assumed_arm(
    robot: RobotModel, stiffness_error: float, seed: int, cfg: NominalCfg = NominalCfg()
) -> NominalArm:
    """The arm as its owner assumes it: the stiffness of each gear is wrong by a uniform factor in 1
    +- `stiffness_error`, beside those of `cfg`."""
    rng = np.random.default_rng([seed, _STREAM])
    stiffness_error += 0.0  # no -0.0, from which to 0.0 is no range to numpy
    factors = 1.0 + rng.uniform(-stiffness_error, stiffness_error, robot.n_axes)
    return nominal_arm(robot, replace(cfg, stiffness=tuple(factors * cfg.stiffness)))
