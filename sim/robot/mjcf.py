"""Names and custom numerics that a robot's MJCF must have, their lookup and their plausibility.

The names are those listed in the `armside.assets` docstring.
"""

from pathlib import Path

import mujoco
import numpy as np

from armside.arrays import Array

MOST_AXES = 9
"""Axes that a robot has at most."""
N_AXES = 6
"""Axes of the robots that have twins and tuning environments."""
AXES = range(1, N_AXES + 1)
"""Those axes, counted from 1."""


def axes_of(mj: mujoco.MjModel) -> range:
    """Axes of a robot, counted from 1: up to the last that has a motor or an actuator."""
    kinds = ((mujoco.mjtObj.mjOBJ_JOINT, "motor"), (mujoco.mjtObj.mjOBJ_ACTUATOR, "axis"))
    named = (i for i in range(1, MOST_AXES + 2) if any(has(mj, k, f"{p}_{i}") for k, p in kinds))
    return range(1, max(named, default=1) + 1)


def _required(axes: range) -> dict[mujoco.mjtObj, list[str]]:
    return {
        mujoco.mjtObj.mjOBJ_JOINT: [f"motor_{i}" for i in axes],
        mujoco.mjtObj.mjOBJ_ACTUATOR: [f"axis_{i}" for i in axes],
        mujoco.mjtObj.mjOBJ_SITE: ["tool0", "imu", "tracker_target"],
        mujoco.mjtObj.mjOBJ_SENSOR: [
            *(f"axis_{i}_{quantity}" for i in axes for quantity in ("pos", "torque")),
            *("imu_acc", "imu_gyro", "tool0_pos", "tool0_quat"),
        ],
        mujoco.mjtObj.mjOBJ_NUMERIC: [
            *("gear_ratio", "encoder_counts", "speed_limit", "velocity_feedforward"),
            *("correction_delay", "correction_lag", "elastic_compensation", "torque_noise"),
        ],
    }


class ModelError(ValueError):
    """An MJCF file that cannot serve as a robot of this project."""


def require_names(mj: mujoco.MjModel) -> None:
    """Raise ModelError for a model that lacks a name that every robot has, or has too many axes."""
    axes = axes_of(mj)
    if len(axes) > MOST_AXES:
        raise ModelError(f"a robot has at most {MOST_AXES} axes, the model has axis {axes[-1]}")
    for kind, names in _required(axes).items():
        missing = [name for name in names if not has(mj, kind, name)]
        if missing:
            word = kind.name.removeprefix("mjOBJ_").lower()
            raise ModelError(f"the robot model lacks the {word} {', '.join(missing)}")


def has(mj: mujoco.MjModel, kind: mujoco.mjtObj, name: str) -> bool:
    """True for a model with an element of that kind and name."""
    return mujoco.mj_name2id(mj, kind, name) >= 0


def model_name(mj: mujoco.MjModel) -> str:
    """Name of the model in its file."""
    return bytes(mj.names).partition(b"\0")[0].decode()


def axis_actuators(mj: mujoco.MjModel) -> list[int]:
    """Actuator of each axis, axis_1..n."""
    return [mj.actuator(f"axis_{i}").id for i in axes_of(mj)]


def numeric(mj: mujoco.MjModel, name: str, size: int) -> Array:
    """Values of a custom numeric of the file. Raises ModelError for another number of them."""
    values = np.array(mj.numeric(name).data, dtype=np.float64)
    if values.size != size:
        raise ModelError(f"numeric {name} must hold {size} values, holds {values.size}")
    return values


def scalar(mj: mujoco.MjModel, name: str, default: float | None = None) -> float:
    """Value of a custom numeric of one number; the default where the file has none."""
    if default is not None and not has(mj, mujoco.mjtObj.mjOBJ_NUMERIC, name):
        return default
    return float(numeric(mj, name, 1)[0])


def mass_matrix(mj: mujoco.MjModel, qpos: Array, data: mujoco.MjData | None = None) -> Array:
    """(nv, nv) inertia of all joints at positions (nq,); `data` is left there, after mj_forward."""
    data, M = data or mujoco.MjData(mj), np.zeros((mj.nv, mj.nv))
    data.qpos[:] = qpos
    mujoco.mj_forward(mj, data)
    mujoco.mj_fullM(mj, data, M)
    return M


def write_robot(file: Path, spec: mujoco.MjSpec) -> None:
    """Write a robot's MJCF, includes inserted. Meshes stay where they are, by absolute path."""
    own = spec.copy()
    folder = Path(spec.modelfiledir).resolve()
    if any(mesh.file for mesh in own.meshes):
        own.meshdir = str(folder / spec.meshdir)
    if any(texture.file for texture in own.textures):
        own.texturedir = str(folder / spec.texturedir)
    own.compile()
    file.write_text(own.to_xml(), encoding="utf-8")


ANY_SIGN = ("gear_error_phase", "gear_temperature", "elastic_compensation", "link_")
"""Beginnings of the names of custom numerics that may be negative."""
ABOVE_ZERO = ("gear_ratio", "speed_limit", "encoder_counts", "correction_lag")


def refuse_implausible(mj: mujoco.MjModel) -> None:
    """Raise ModelError for a custom numeric that is not finite or has the wrong sign, for a link
    without mass, and for negative stiffness, damping, armature or friction of a joint."""
    for i in range(mj.nnumeric):
        name, values = mj.numeric(i).name, mj.numeric(i).data
        if not np.isfinite(values).all():
            raise ModelError(f"numeric {name} must be finite")
        if name in ABOVE_ZERO and values.min() <= 0.0:
            raise ModelError(f"numeric {name} must be above 0, got {values.min():g}")
        if not name.startswith(ANY_SIGN) and values.min() < 0.0:
            raise ModelError(f"numeric {name} must be >= 0, got {values.min():g}")
    for i in axes_of(mj):
        link = mj.body(int(mj.joint(f"motor_{i}").bodyid[0]))
        if not link.mass[0] > 0.0:
            moved = f"the body {link.name}, which motor_{i} moves"
            raise ModelError(f"{moved}, must have a mass > 0 kg")
    for what, values, joint in (
        ("damping", mj.dof_damping, mj.dof_jntid),
        ("armature", mj.dof_armature, mj.dof_jntid),
        ("frictionloss", mj.dof_frictionloss, mj.dof_jntid),
        ("stiffness", mj.jnt_stiffness, np.arange(mj.njnt)),
    ):
        if (wrong := np.flatnonzero(~(values >= 0.0))).size:
            name = mj.joint(int(joint[wrong[0]])).name
            raise ModelError(f"{what} of the joint {name} must be >= 0, got {values[wrong[0]]:g}")


def refuse_negative_mass(spec: mujoco.MjSpec) -> None:
    """Raise ModelError for a mass that MuJoCo would take for zero."""
    for body in spec.bodies:
        if body.mass < 0.0:
            raise ModelError(f"mass of the body {body.name} must be >= 0 kg, got {body.mass:g}")
