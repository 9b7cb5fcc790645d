"""A robot's MJCF with its names resolved: which joint is which axis, and what its controller knows.

Both robots of the project, and any robot of a user, expose the names listed in the `assets`
package docstring. A model that lacks one is refused with the names that are missing.
"""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from armside.arrays import Array

from .gear_error import GearError as GearError
from .linkage import passive_joints

N_AXES = 6
AXES = range(1, N_AXES + 1)


class ModelError(ValueError):
    """An MJCF file that cannot serve as a robot of this project."""


@dataclass(frozen=True, kw_only=True)
class Drives:
    """The six drives as their controller knows them. Motor units: before the gear."""

    gear: Array
    """(6,) gear ratio, motor angle over arm-side angle."""
    kp: Array
    """(6,) [N m/rad]."""
    ki: Array
    """(6,) [N m/(rad s)]."""
    kd: Array
    """(6,) [N m s/rad]."""
    torque_limit: Array
    """(6,) [N m]."""
    speed_limit: Array
    """(6,) [rad/s], arm side."""
    encoder_counts: float
    """Counts per motor turn; 0 for an ideal encoder."""
    encoder_noise: float
    """[counts rms], white at the rate of the servo."""
    velocity_feedforward: Array
    """(6,) share of the reference velocity that is fed forward."""
    torque_feedforward: float
    """Share of the rigid computed torque, and of friction, that is fed forward."""
    friction_feedforward: float
    """Share of friction that is fed forward."""
    friction_curve: bool
    """Whether the controller knows the whole curve of friction, or Coulomb friction alone."""
    coulomb_friction: Array
    """(6,) [N m]."""
    static_friction: Array
    """(6,) [N m]."""
    stribeck_speed: Array
    """(6,) [rad/s]."""
    viscous_friction: Array
    """(6,) [N m s/rad]."""
    correction_delay: float
    """[s], before a correction reaches the servo."""
    correction_lag: float
    """[Hz], first-order lag on the way of a correction."""
    elastic_compensation: float
    """Share of the quasi-static elastic deflection that the reference anticipates."""
    torque_noise: float
    """Non-repeatable torque, rms relative to the torque limit."""
    torque_noise_bandwidth: float
    """[Hz]."""


@dataclass(frozen=True, kw_only=True)
class RobotModel:
    """A compiled MJCF with the indices and the drive data that the virtual robot needs."""

    mj: mujoco.MjModel
    motor: np.ndarray
    """(6,) degree of freedom of each motor."""
    flex: np.ndarray
    """(6,) degree of freedom of each gear spring; (0,) where the gears are rigid."""
    posture: Array
    """(nv, 6): joint angles are posture @ phi while every spring is at zero. Passive joints of a
    closed chain follow the motors there."""
    integrator: np.ndarray
    """(6,) activation that holds the integral of each axis' position error; (0,) without any."""
    springs: np.ndarray
    """Degrees of freedom with a joint spring: gears, then structure."""
    drives: Drives
    gear_error: GearError | None = None
    """Transmission error of the gears; None for exact gears."""
    joint_range: Array
    """(6, 2) [rad], hard stops of the motors on the arm side."""
    brakes: np.ndarray
    """(6,) equality constraints that hold a motor; (0,) for a robot without brakes."""
    sensors: dict[str, slice]
    """Columns of `sensordata` by sensor name."""

    @property
    def implicit(self) -> bool:
        """Whether velocity feedback acts on the velocity at the end of a step."""
        return int(self.mj.opt.integrator) not in (
            int(mujoco.mjtIntegrator.mjINT_EULER),
            int(mujoco.mjtIntegrator.mjINT_RK4),
        )

    @property
    def timestep(self) -> float:
        """Physics step [s]."""
        return float(self.mj.opt.timestep)


def load_model(source: Path | str | mujoco.MjModel) -> RobotModel:
    """Compile an MJCF file and resolve its names.

    Raises ModelError when the file does not compile or lacks a name.
    """
    mj = source if isinstance(source, mujoco.MjModel) else _compile(Path(source))
    _require_names(mj)
    motor = _dofs(mj, "motor")
    springs = np.flatnonzero(mj.jnt_stiffness > 0.0)
    sensors = {
        mj.sensor(i).name: slice(int(mj.sensor_adr[i]), int(mj.sensor_adr[i] + mj.sensor_dim[i]))
        for i in range(mj.nsensor)
    }
    return RobotModel(
        mj=mj,
        motor=motor,
        flex=_flex_dofs(mj),
        posture=_posture(mj, motor),
        integrator=_integrators(mj),
        springs=mj.jnt_dofadr[springs],
        drives=_drives(mj),
        joint_range=np.array([mj.joint(f"motor_{i}").range for i in AXES]),
        brakes=_brakes(mj),
        sensors=sensors,
    )


def _compile(path: Path) -> mujoco.MjModel:
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        first_line = str(error).strip().splitlines()[0]
        raise ModelError(f"{path} is not a usable MJCF model: {first_line}") from error


def _require_names(mj: mujoco.MjModel) -> None:
    needed = {
        mujoco.mjtObj.mjOBJ_JOINT: [f"motor_{i}" for i in AXES],
        mujoco.mjtObj.mjOBJ_ACTUATOR: [f"axis_{i}" for i in AXES],
        mujoco.mjtObj.mjOBJ_SITE: ["tool0", "imu", "tracker_target"],
        mujoco.mjtObj.mjOBJ_SENSOR: [
            *(f"axis_{i}_{what}" for i in AXES for what in ("pos", "torque")),
            "imu_acc",
            "imu_gyro",
            "tool0_pos",
            "tool0_quat",
        ],
        mujoco.mjtObj.mjOBJ_NUMERIC: [
            "gear_ratio",
            "encoder_counts",
            "velocity_feedforward",
            "correction_delay",
            "correction_lag",
            "elastic_compensation",
            "torque_noise",
            "speed_limit",
        ],
    }
    for kind, names in needed.items():
        missing = [name for name in names if mujoco.mj_name2id(mj, kind, name) < 0]
        if missing:
            word = kind.name.removeprefix("mjOBJ_").lower()
            raise ModelError(f"the robot model lacks the {word} {', '.join(missing)}")


def _dofs(mj: mujoco.MjModel, kind: str) -> np.ndarray:
    return np.array([int(mj.joint(f"{kind}_{i}").dofadr[0]) for i in AXES])


def _flex_dofs(mj: mujoco.MjModel) -> np.ndarray:
    """Gear springs of all axes, or none: a rigid form of a robot has none."""
    present = [i for i in AXES if _has(mj, mujoco.mjtObj.mjOBJ_JOINT, f"flex_{i}")]
    if present and len(present) < N_AXES:
        absent = ", ".join(f"flex_{i}" for i in AXES if i not in present)
        raise ModelError(f"the robot model lacks the joint {absent}; give all six or none")
    return _dofs(mj, "flex") if present else np.array([], dtype=int)


def _posture(mj: mujoco.MjModel, motor: np.ndarray) -> Array:
    """Motors are their own angles; the model states how each passive joint follows them."""
    posture = np.zeros((mj.nv, N_AXES))
    posture[motor, range(N_AXES)] = 1.0
    for dof in passive_joints(mj):
        name = mj.joint(int(mj.dof_jntid[dof])).name
        if _has(mj, mujoco.mjtObj.mjOBJ_NUMERIC, name):
            posture[dof] = numeric(mj, name, N_AXES)
    return posture


def _integrators(mj: mujoco.MjModel) -> np.ndarray:
    """A dcmotor with an integral gain keeps its integral first among its activations."""
    actuators = [mj.actuator(f"axis_{i}").id for i in AXES]
    if not mj.actuator_gainprm[actuators, 5].any():
        return np.array([], dtype=int)
    return mj.actuator_actadr[actuators].copy()


def _brakes(mj: mujoco.MjModel) -> np.ndarray:
    names = [f"brake_{i}" for i in AXES]
    if not all(_has(mj, mujoco.mjtObj.mjOBJ_EQUALITY, name) for name in names):
        return np.array([], dtype=int)
    return np.array([mj.eq(name).id for name in names])


def _has(mj: mujoco.MjModel, kind: mujoco.mjtObj, name: str) -> bool:
    return mujoco.mj_name2id(mj, kind, name) >= 0


def _drives(mj: mujoco.MjModel) -> Drives:
    actuators = [mj.actuator(f"axis_{i}").id for i in AXES]
    noise, bandwidth = numeric(mj, "torque_noise", 2)
    return Drives(
        gear=numeric(mj, "gear_ratio", N_AXES),
        kp=mj.actuator_gainprm[actuators, 4].copy(),
        ki=mj.actuator_gainprm[actuators, 5].copy(),
        kd=mj.actuator_gainprm[actuators, 6].copy(),
        torque_limit=mj.actuator_forcerange[actuators, 1].copy(),
        speed_limit=numeric(mj, "speed_limit", N_AXES),
        encoder_counts=float(numeric(mj, "encoder_counts", 1)[0]),
        velocity_feedforward=numeric(mj, "velocity_feedforward", N_AXES),
        correction_delay=float(numeric(mj, "correction_delay", 1)[0]),
        correction_lag=float(numeric(mj, "correction_lag", 1)[0]),
        elastic_compensation=float(numeric(mj, "elastic_compensation", 1)[0]),
        torque_feedforward=_optional(mj, "torque_feedforward", 1.0),
        friction_feedforward=_optional(mj, "friction_feedforward", 0.0),
        friction_curve=bool(_optional(mj, "friction_curve", 0.0)),
        coulomb_friction=mj.actuator_biasprm[actuators, 3].copy(),
        static_friction=mj.actuator_biasprm[actuators, 4].copy(),
        stribeck_speed=mj.actuator_biasprm[actuators, 5].copy(),
        viscous_friction=mj.actuator_damping[actuators].copy(),
        encoder_noise=_optional(mj, "encoder_noise", 0.0),
        torque_noise=float(noise),
        torque_noise_bandwidth=float(bandwidth),
    )


def numeric(mj: mujoco.MjModel, name: str, size: int) -> Array:
    """Values of a custom numeric of the file. Raises ModelError for another number of them."""
    values = np.array(mj.numeric(name).data, dtype=np.float64)
    if values.size != size:
        raise ModelError(f"numeric {name} must hold {size} values, holds {values.size}")
    return values


def _optional(mj: mujoco.MjModel, name: str, default: float) -> float:
    if not _has(mj, mujoco.mjtObj.mjOBJ_NUMERIC, name):
        return default
    return float(numeric(mj, name, 1)[0])
