"""A compiled robot model: axes, springs, sensors and drives found by name in its MJCF."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from armside.arrays import Array

from .drives import Drives, GearError, OwnDrive, read_drives
from .linkage import passive_joints
from .mjcf import (
    ModelError,
    axes_of,
    axis_actuators,
    has,
    numeric,
    refuse_implausible,
    refuse_negative_mass,
    require_names,
)


@dataclass(frozen=True, kw_only=True)
class RobotModel:
    """A compiled MJCF with the indices and the drive data that the virtual robot needs."""

    mj: mujoco.MjModel
    motor: np.ndarray
    """(n,) degree of freedom of each motor."""
    flex: np.ndarray
    """(n,) degree of freedom of each gear spring; (0,) where the gears are rigid."""
    posture: Array
    """(nv, n): joint angles are posture @ phi while every spring is at zero. Passive joints of a
    closed chain follow the motors there."""
    integrator: np.ndarray
    """(n,) activation that holds the integral of each axis' position error; (0,) without any."""
    springs: np.ndarray
    """Degrees of freedom with a joint spring: gears, then structure."""
    drives: Drives
    gear_error: GearError | None = None
    """Transmission error of the gears; None for exact gears."""
    own_drive: OwnDrive | None = None
    """What the drives do beside what those of all robots do."""
    joint_range: Array
    """(n, 2) [rad], hard stops of the motors on the arm side."""
    brakes: np.ndarray
    """(n,) equality constraints that hold a motor; (0,) for a robot without brakes."""
    sensors: dict[str, slice]
    """Columns of `sensordata` by sensor name."""
    spec: mujoco.MjSpec | None = field(default=None, repr=False, compare=False)
    """The parsed file; None for a model that was not loaded from one, or sent to this process."""

    def parsed(self) -> mujoco.MjSpec:
        """A copy of the parsed file, to derive other models from. Raises ModelError without one."""
        if self.spec is None:
            raise ModelError("a model can be derived only from one that was loaded from its file")
        return self.spec.copy()

    def __getstate__(self) -> dict[str, Any]:
        # MuJoCo cannot pickle a parsed file.
        return {**self.__dict__, "spec": None}

    @property
    def n_axes(self) -> int:
        """Number of axes."""
        return len(self.motor)

    @property
    def implicit(self) -> bool:
        """True where velocity feedback acts on the velocity at the end of a step."""
        explicit = mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtIntegrator.mjINT_RK4
        return int(self.mj.opt.integrator) not in map(int, explicit)

    @property
    def timestep(self) -> float:
        """Physics step [s]."""
        return float(self.mj.opt.timestep)


def load_model(source: Path | str | mujoco.MjModel) -> RobotModel:
    """Robot model of an MJCF file or a compiled model. Raises ModelError for one that is none."""
    if isinstance(source, mujoco.MjModel):
        return _named(None, source)
    try:
        spec = mujoco.MjSpec.from_file(str(Path(source)))
        refuse_negative_mass(spec)
        mj = spec.compile()
    except ValueError as error:
        first_line = str(error).strip().splitlines()[0]
        raise ModelError(f"{source} is not a usable MJCF model: {first_line}") from error
    return _named(spec, mj)


def robot_model(spec: mujoco.MjSpec) -> RobotModel:
    """Robot model of a parsed file, altered or not. Raises ModelError as `load_model`."""
    return _named(spec, spec.compile())


def _named(spec: mujoco.MjSpec | None, mj: mujoco.MjModel) -> RobotModel:
    require_names(mj)
    refuse_implausible(mj)
    motor, actuators = _dofs(mj, "motor"), axis_actuators(mj)
    integral = mj.actuator_gainprm[actuators, 5].any()  # the first activation of a dcmotor
    brakes = [
        mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_EQUALITY, f"brake_{i}") for i in axes_of(mj)
    ]
    sensors = map(mj.sensor, range(mj.nsensor))
    return RobotModel(
        mj=mj,
        spec=spec,
        motor=motor,
        flex=_flex_dofs(mj),
        posture=posture(mj, motor),
        integrator=mj.actuator_actadr[actuators].copy() if integral else np.array([], dtype=int),
        springs=mj.jnt_dofadr[np.flatnonzero(mj.jnt_stiffness > 0.0)],
        drives=read_drives(mj),
        joint_range=np.array([mj.joint(f"motor_{i}").range for i in axes_of(mj)]),
        brakes=np.array(brakes if min(brakes) >= 0 else [], dtype=int),
        sensors={s.name: slice(int(s.adr[0]), int(s.adr[0] + s.dim[0])) for s in sensors},
    )


def _dofs(mj: mujoco.MjModel, kind: str) -> np.ndarray:
    return np.array([int(mj.joint(f"{kind}_{i}").dofadr[0]) for i in axes_of(mj)])


def _flex_dofs(mj: mujoco.MjModel) -> np.ndarray:
    """Gear springs of all axes, or none: a rigid form of a robot has none."""
    axes = axes_of(mj)
    present = [i for i in axes if has(mj, mujoco.mjtObj.mjOBJ_JOINT, f"flex_{i}")]
    if present and len(present) < len(axes):
        absent = ", ".join(f"flex_{i}" for i in axes if i not in present)
        raise ModelError(f"the robot model lacks the joint {absent}; give all {len(axes)} or none")
    return _dofs(mj, "flex") if present else np.array([], dtype=int)


def posture(mj: mujoco.MjModel, motor: np.ndarray) -> Array:
    """(nv, n) joint angles for those of the axes, at degrees of freedom `motor` (n,).

    Motors are their own angles; the model states how each passive joint follows them.
    """
    n = len(motor)
    posture = np.zeros((mj.nv, n))
    posture[motor, range(n)] = 1.0
    for dof in passive_joints(mj):
        name = mj.joint(int(mj.dof_jntid[dof])).name
        if has(mj, mujoco.mjtObj.mjOBJ_NUMERIC, name):
            posture[dof] = numeric(mj, name, n)
    return posture
