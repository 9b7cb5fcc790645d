"""What real gears and drives do beyond linear springs and one friction curve, switched on by name.

The MJCF carries the data of each effect; a loaded model has none of them, as its controller does.
"""

import copy
from collections.abc import Collection
from dataclasses import replace
from enum import Enum

import numpy as np

from armside.arrays import Array

from .model import AXES, GearError, RobotModel, numeric
from .statics import Statics

_COGGING = slice(0, 3)  # dcmotor: amplitude [N m], order, phase [rad]
_COULOMB, _STATIC, _STRIBECK = 3, 4, 5  # dcmotor: LuGre [N m], [N m], [rad/s]


class Effect(Enum):
    """An effect that a reproduction can be run with and without."""

    LOST_MOTION = "lost-motion"
    """Gears are soft in the middle and stiff outside."""
    GEAR_ERROR = "gear-error"
    """The output of a gear is not exactly its input over its ratio."""
    RIPPLE = "ripple"
    """Torque of a motor depends on its angle."""
    LOAD_FRICTION = "load-friction"
    """Friction follows from holding torque and temperature. Frozen per pose."""


_DATA = {
    Effect.LOST_MOTION: "gear_soft_stiffness",
    Effect.GEAR_ERROR: "gear_error",
    Effect.RIPPLE: "torque_ripple",
    Effect.LOAD_FRICTION: "load_friction_scale",
}


def available(model: RobotModel) -> frozenset[Effect]:
    """The effects that a robot's file has data for."""
    numerics = {model.mj.numeric(i).name for i in range(model.mj.nnumeric)}
    return frozenset(effect for effect, name in _DATA.items() if name in numerics)


def with_effects(model: RobotModel, effects: Collection[Effect], *, phi: Array) -> RobotModel:
    """The robot with these effects added.

    Args:
        phi: (6,) [rad], pose that friction is frozen at.
    """
    mj = copy.copy(model.mj)
    model = replace(model, mj=mj)
    if Effect.LOST_MOTION in effects:
        _soften(model)
    if Effect.RIPPLE in effects:
        amplitude, order = numeric(mj, "torque_ripple", 2)
        for i in range(len(AXES)):
            mj.actuator_biasprm[_axis(model, i), _COGGING] = (
                amplitude * model.drives.torque_limit[i],
                order,
                0.0,
            )
    if Effect.GEAR_ERROR in effects:
        model = replace(model, gear_error=_gear_error(model))
    if Effect.LOAD_FRICTION in effects:
        model = _loaded(model, phi)
    return model


def _axis(model: RobotModel, i: int) -> int:
    return model.mj.actuator(f"axis_{i + 1}").id


def _soften(model: RobotModel) -> None:
    """Joint spring soft; the tendon adds the rest outside the lost motion (a deadband)."""
    mj = model.mj
    soft, half = numeric(mj, "gear_soft_stiffness", 6), numeric(mj, "gear_lost_motion", 6)
    for i in range(len(AXES)):
        joint, tendon = mj.joint(f"flex_{i + 1}").id, mj.tendon(f"gear_{i + 1}").id
        mj.tendon_stiffness[tendon] = mj.jnt_stiffness[joint] - soft[i]
        mj.tendon_lengthspring[tendon] = (-half[i], half[i])
        mj.jnt_stiffness[joint] = soft[i]


def _gear_error(model: RobotModel) -> GearError:
    amplitude = numeric(model.mj, "gear_error", 4)
    gear = model.drives.gear
    return GearError(
        amplitude=np.tile(amplitude, (len(AXES), 1)),
        order=np.column_stack([np.ones(6), 2.0 * np.ones(6), gear, 2.0 * gear]),
        phase=numeric(model.mj, "gear_error_phase", 24).reshape(6, 4),
    )


# Bittencourt's model of an ABB axis, identified on axis 2 of an IRB6620 (26 N m), in parts of the
# peak torque: robot-data 3.3 after Yan, Li, Meng 2020.
_FC0, _FCL, _FSL, _FS0, _FST, _FV0, _FVT = 0.0311, 0.0234, 0.126, -0.025, 0.0016, 1.3e-4, 1.32e-3


def load_friction(load: Array, temperature: float) -> tuple[Array, Array, float, float]:
    """Friction in parts of the peak torque at a load, also in parts of the peak torque.

    Returns:
        Coulomb and static friction, shape of `load`; viscous [s/rad]; Stribeck speed [rad/s].
    """
    load = np.abs(load)
    coulomb = _FC0 + _FCL * load
    static = coulomb + _FSL * load + _FS0 + _FST * temperature
    viscous = _FV0 + _FVT * np.exp(-temperature / 20.71)
    return coulomb, static, viscous, -24.81 + 0.98 * temperature


def _loaded(model: RobotModel, phi: Array) -> RobotModel:
    limit, gear = model.drives.torque_limit, model.drives.gear
    load = Statics(model).equilibrium(phi).holding_torque / gear / limit
    (temperature,) = numeric(model.mj, "gear_temperature", 1)
    coulomb, static, viscous, stribeck = load_friction(load, temperature)
    scale = numeric(model.mj, "load_friction_scale", 6)
    (excess,) = numeric(model.mj, "load_friction_static", 1)
    static = coulomb + excess * (static - coulomb)
    mj = model.mj
    for i in range(len(AXES)):
        axis = _axis(model, i)
        mj.actuator_biasprm[axis, _COULOMB] = scale[i] * coulomb[i] * limit[i]
        mj.actuator_biasprm[axis, _STATIC] = scale[i] * static[i] * limit[i]
        mj.actuator_biasprm[axis, _STRIBECK] = stribeck
        mj.actuator_damping[axis] = viscous * limit[i]
    return replace(model, mj=mj)
