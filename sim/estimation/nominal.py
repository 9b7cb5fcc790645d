"""The nominal arm of an estimator: links on springs whose other ends are the measured motors.

The motors are taken out of the robot's MJCF and with them everything that only moves them (rotors,
friction, servo): their angles are measured, so they are an input,

    M(q) q'' + c(q, q') + g(q) = K (phi - q) + D (phi' - q')

with q the arm's angles and phi the motor's, both on the arm side of the gear. This is the *nominal*
robot: `NominalCfg` sets its errors, and nothing is read from an individual.

K is symmetric. The gears are its diagonal; the elasticity of the structure, which the nominal robot
lacks, couples the axes by entries off the diagonal. A closed chain is reduced to its free joints.
"""

import copy
import itertools
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
from .coupled_axes import coupled_axes


def pairs_of(n_axes: int) -> tuple[tuple[int, int], ...]:
    """Couplings of two axes, counted from 0."""
    return tuple(itertools.combinations(range(n_axes), 2))


@dataclass(frozen=True, kw_only=True)
class NominalCfg:
    """Assumed parameters of an arm, relative to the data of its file."""

    stiffness: float | tuple[float, ...] = 1.0
    """Factor on each gear's stiffness, or one for all."""
    damping: float = 1.0
    """Factor on the damping of all gears."""
    payload: float = 0.0
    """Added to the mass of the tool [kg]."""
    link_mass: float = 1.0
    """Factor on mass and inertia of every body."""
    structure: bool = False
    """The hinges of the structure are known too."""

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "link_mass"):
            value = np.asarray(getattr(self, name))
            if not (np.isfinite(value).all() and (value > 0.0).all()):
                raise ValueError(f"factors of {name} must be > 0, got {value.tolist()}")


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalArm:
    """The model of `NominalCfg`, compiled, with its springs and indices."""

    mj: mujoco.MjModel
    """Actuators spring_1..n pull the axes towards the angles they are given, spring_i_j their
    differences."""
    axes: np.ndarray
    """(n,) each axis among the free joints."""
    stiffness: Array
    """(n, n) [N m/rad], symmetric; diagonal as long as only gears are known."""
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

    @cached_property
    def coupled(self) -> tuple[tuple[int, int], ...]:
        """Axes that the structure may couple, counted from 0."""
        return coupled_axes(self.mj, [f"flex_{i + 1}" for i in range(len(self.axes))])

    @property
    def n_free(self) -> int:
        """Free joints: the axes, and those of the structure if it is known."""
        return len(self.motion.joints)

    def with_springs(self, stiffness: ArrayLike, damping: ArrayLike) -> "NominalArm":
        """The same arm on other springs: stiffness (n, n) symmetric, damping (n,).

        Raises ValueError for a stiffness that is not symmetric.
        """
        K, D = np.array(stiffness, dtype=np.float64), np.array(damping, dtype=np.float64)
        n = len(self.axes)
        if K.shape != (n, n) or not np.allclose(K, K.T):
            raise ValueError(f"stiffness must be symmetric, ({n}, {n})")
        mj = copy.copy(self.mj)
        _set_springs(mj, K, D)
        return replace(self, mj=mj, stiffness=K, damping=D)

    def spring_input(self, phi: Array, phi_dot: Array) -> Array:
        """(..., n (n + 1) / 2) controls of motor angles and rates (..., n).

        K (phi - q) + D (phi' - q') = K (control - q) - D q', D on the axes' own springs alone.
        """
        own = self.stiffness.sum(axis=1)
        axes = phi + self.damping / own * phi_dot
        pairs = [phi[..., i] - phi[..., j] for i, j in pairs_of(phi.shape[-1])]
        return np.concatenate((axes, *(pair[..., None] for pair in pairs)), axis=-1)


def nominal_arm(robot: RobotModel, cfg: NominalCfg = NominalCfg()) -> NominalArm:
    """Nominal arm of a robot loaded from its MJCF file, as the file has it: payload and all.

    Raises:
        ModelError: the robot's arm lacks a gear spring or the body of the tool, or has an equality
            that neither closes a chain nor is a brake.
    """
    spec = robot.parsed()
    _release_brakes(spec)
    numbers = range(1, robot.n_axes + 1)
    missing = [f"flex_{i}" for i in numbers if spec.joint(f"flex_{i}") is None]
    if missing:
        raise ModelError(f"the robot model lacks the joint {', '.join(missing)}")
    gears = [(j.stiffness, j.damping) for j in (spec.joint(f"flex_{i}") for i in numbers)]
    stiffness = np.array([float(np.ravel(k)[0]) for k, _ in gears]) * cfg.stiffness
    damping = np.array([float(np.ravel(d)[0]) for _, d in gears]) * cfg.damping
    if not cfg.structure:
        without(spec, Flexibility.GEARS)
    _replace_motors_by_springs(spec, robot.n_axes)
    _reweigh(spec, cfg)
    mj = spec.compile()
    gear_dofs = [int(mj.joint(f"flex_{i}").dofadr[0]) for i in numbers]
    axes = np.searchsorted(free_joints(mj), gear_dofs)
    arm = NominalArm(mj=mj, axes=axes, stiffness=np.diag(stiffness), damping=damping)
    return arm.with_springs(arm.stiffness, damping)


def _release_brakes(spec: mujoco.MjSpec) -> None:
    """Delete the brakes, which hold motors. Raises ModelError for equalities of another kind."""
    for equality in list(spec.equalities):
        if equality.name.startswith("brake_"):
            spec.delete(equality)
        elif equality.type != mujoco.mjtEq.mjEQ_CONNECT:
            allowed = "an estimator takes brakes and connections of closed chains"
            raise ModelError(f"{allowed}, not the equality {equality.name!r}")


def _replace_motors_by_springs(spec: mujoco.MjSpec, n_axes: int) -> None:
    numbers = range(1, n_axes + 1)
    for i in numbers:
        spec.delete(spec.actuator(f"axis_{i}"))
        for what in ("pos", "torque"):
            spec.delete(spec.sensor(f"axis_{i}_{what}"))
    for tendon in list(spec.tendons):
        if tendon.name.startswith("gear_"):
            spec.delete(tendon)
    for i in numbers:
        spec.delete(spec.joint(f"motor_{i}"))
        gear = spec.joint(f"flex_{i}")
        gear.stiffness, gear.damping = np.zeros_like(gear.stiffness), np.zeros_like(gear.damping)
        _add_spring(spec, f"spring_{i}", mujoco.mjtTrn.mjTRN_JOINT, gear.name)
    for i, j in pairs_of(n_axes):
        name = f"spring_{i + 1}_{j + 1}"
        difference = spec.add_tendon(name=name)
        difference.wrap_joint(f"flex_{i + 1}", 1.0)
        difference.wrap_joint(f"flex_{j + 1}", -1.0)
        _add_spring(spec, name, mujoco.mjtTrn.mjTRN_TENDON, name)


def _add_spring(spec: mujoco.MjSpec, name: str, kind: mujoco.mjtTrn, target: str) -> None:
    spring = spec.add_actuator(name=name, target=target)
    spring.trntype = kind
    spring.gaintype, spring.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE


def _reweigh(spec: mujoco.MjSpec, cfg: NominalCfg) -> None:
    for body in spec.bodies:
        body.mass *= cfg.link_mass
        body.inertia = np.asarray(body.inertia) * cfg.link_mass
    if cfg.payload:
        tool = spec.body("tool")
        if tool is None:
            raise ModelError("the robot model lacks the body tool, which carries the payload")
        if tool.mass + cfg.payload < 0.0:
            change = f"{cfg.payload:+g} kg leaves less than nothing of its {tool.mass:g} kg"
            raise ValueError(f"the payload of the assumed arm must be >= 0 kg: {change}")
        # A payload of other mass and the same shape.
        tool.inertia = np.asarray(tool.inertia) * (1.0 + cfg.payload / tool.mass)
        tool.mass += cfg.payload


def _set_springs(mj: mujoco.MjModel, stiffness: Array, damping: Array) -> None:
    # A spring between two axes adds to both diagonal entries, which the axes' own springs give up.
    own = stiffness.sum(axis=1)
    pairs = pairs_of(len(own))
    names = [f"spring_{i + 1}" for i in range(len(own))]
    names += [f"spring_{i + 1}_{j + 1}" for i, j in pairs]
    k_all = [*own, *(0.0 - stiffness[i, j] for i, j in pairs)]
    for name, k, d in zip(names, k_all, [*damping, *np.zeros(len(pairs))], strict=True):
        spring = mj.actuator(name).id
        mj.actuator_gainprm[spring, 0] = k
        mj.actuator_biasprm[spring, :3] = (0.0, -k, -d)
