"""Numbers of an MJCF that no robot has: MuJoCo takes them without a word."""

import mujoco
import numpy as np

from .mjcf import ModelError, axes_of

ANY_SIGN = ("gear_error_phase", "gear_temperature", "elastic_compensation", "link_")
"""Beginnings of the names of custom numerics that may be negative."""
ABOVE_ZERO = ("gear_ratio", "speed_limit", "encoder_counts", "correction_lag")
_DOFS = {"damping": "dof_damping", "armature": "dof_armature", "frictionloss": "dof_frictionloss"}


def refuse_implausible(mj: mujoco.MjModel) -> None:
    """Raise ModelError for a custom numeric that is not finite or has the wrong sign, for a link
    without mass, and for negative stiffness, damping, armature or friction of a joint."""
    for i in range(mj.nnumeric):
        one = mj.numeric(i)
        _check(one.name, one.data)
    for i in axes_of(mj):
        link = mj.body(int(mj.joint(f"motor_{i}").bodyid[0]))
        if not link.mass[0] > 0.0:
            raise ModelError(
                f"the body {link.name}, which motor_{i} moves, must have a mass > 0 kg"
            )
    for what, name in _DOFS.items():
        _not_negative(mj, what, getattr(mj, name), mj.dof_jntid)
    _not_negative(mj, "stiffness", mj.jnt_stiffness, np.arange(mj.njnt))


def refuse_negative_mass(spec: mujoco.MjSpec) -> None:
    """Raise ModelError for a mass that MuJoCo would take for zero."""
    for body in spec.bodies:
        if body.mass < 0.0:
            raise ModelError(f"mass of the body {body.name} must be >= 0 kg, got {body.mass:g}")


def _check(name: str, values: np.ndarray) -> None:
    if not np.isfinite(values).all():
        raise ModelError(f"numeric {name} must be finite")
    if name in ABOVE_ZERO and values.min() <= 0.0:
        raise ModelError(f"numeric {name} must be above 0, got {values.min():g}")
    if not name.startswith(ANY_SIGN) and values.min() < 0.0:
        raise ModelError(f"numeric {name} must be >= 0, got {values.min():g}")


def _not_negative(mj: mujoco.MjModel, what: str, values: np.ndarray, joint: np.ndarray) -> None:
    if (wrong := np.flatnonzero(~(values >= 0.0))).size:
        name = mj.joint(int(joint[wrong[0]])).name
        raise ModelError(f"{what} of the joint {name} must be >= 0, got {values[wrong[0]]:g}")
