"""Nonlinear effects of gears and drives, switched on by name.

The MJCF contains the data of each effect. A loaded model has none of them: it is the nominal model
of the controller, with linear springs and one friction curve.
"""

import copy
from collections.abc import Collection
from dataclasses import dataclass, replace
from enum import Enum

import mujoco
import numpy as np

from armside.arrays import Array

from .drives import N_HARMONICS, GearError
from .mjcf import axis_actuators, has, numeric, scalar
from .model import RobotModel
from .statics import Statics

_COGGING = slice(0, 3)  # dcmotor: amplitude [N m], order, phase [rad]
_COULOMB, _STATIC, _STRIBECK = 3, 4, 5  # dcmotor: LuGre [N m], [N m], [rad/s]


class Effect(Enum):
    """Nonlinear effect of a gear or drive."""

    LOST_MOTION = "lost-motion"
    """Gear springs that are soft in the middle and stiff outside."""
    GEAR_ERROR = "gear-error"
    RIPPLE = "ripple"
    """Motor torque that depends on the motor angle."""
    LOAD_FRICTION = "load-friction"
    """Friction as a function of holding torque and temperature, constant over a run."""


_DATA = {
    Effect.LOST_MOTION: "gear_soft_stiffness",
    Effect.GEAR_ERROR: "gear_error",
    Effect.RIPPLE: "torque_ripple",
    Effect.LOAD_FRICTION: "load_friction_scale",
}


def available(model: RobotModel) -> frozenset[Effect]:
    """Effects that a robot's file has data for."""
    kind = mujoco.mjtObj.mjOBJ_NUMERIC
    return frozenset(effect for effect, name in _DATA.items() if has(model.mj, kind, name))


@dataclass(frozen=True)
class FrictionFactors:
    """Factors on the parts of load friction, (n,) or one for all axes."""

    constant: Array | float = 1.0
    load: Array | float = 1.0
    """On the two parts of Coulomb friction."""
    static_excess: Array | float = 1.0
    """On the excess of static over Coulomb friction."""


def with_effects(
    model: RobotModel,
    effects: Collection[Effect],
    *,
    phi: Array,
    friction: FrictionFactors = FrictionFactors(),
    temperature: float | None = None,
) -> RobotModel:
    """The robot with these effects; load friction is that of the holding torque at phi (n,) [rad].

    temperature: of the gears [deg C]; that of the robot's file if None. Raises ValueError for one
    out of range, or without friction that depends on it.
    """
    if temperature is not None:
        if Effect.LOAD_FRICTION not in effects:
            raise ValueError("temperature needs friction that depends on load and temperature")
        low, high = TEMPERATURES
        if not low <= temperature <= high:
            allowed = f"from {low:g} to {high:g} deg C"
            raise ValueError(f"temperature must be {allowed}, got {temperature:g}")
    model = replace(model, mj=copy.copy(model.mj))
    if Effect.LOST_MOTION in effects:
        _set_lost_motion(model)
    if Effect.RIPPLE in effects:
        size, order = numeric(model.mj, "torque_ripple", 2)
        for axis, limit in zip(axis_actuators(model.mj), model.drives.torque_limit, strict=True):
            model.mj.actuator_biasprm[axis, _COGGING] = (size * limit, order, 0.0)
    if Effect.GEAR_ERROR in effects:
        amplitude, order = gear_orders(model)
        error = GearError(amplitude=amplitude, order=order, phase=gear_phases(model))
        model = replace(model, gear_error=error)
    if Effect.LOAD_FRICTION in effects:
        _set_load_friction(model, phi, friction, temperature)
    return model


def _set_lost_motion(model: RobotModel) -> None:
    """Set soft joint springs; a tendon adds the rest of the stiffness outside the lost motion."""
    mj, n = model.mj, model.n_axes
    soft, half = numeric(mj, "gear_soft_stiffness", n), numeric(mj, "gear_lost_motion", n)
    for i in range(n):
        joint, tendon = mj.joint(f"flex_{i + 1}").id, mj.tendon(f"gear_{i + 1}").id
        mj.tendon_stiffness[tendon] = mj.jnt_stiffness[joint] - soft[i]
        mj.tendon_lengthspring[tendon] = (-half[i], half[i])
        mj.jnt_stiffness[joint] = soft[i]


def gear_orders(model: RobotModel) -> tuple[Array, Array]:
    """Transmission error in a robot's file: amplitudes [rad] and periods a revolution, (n, 4)."""
    gear, once = model.drives.gear, np.ones(model.n_axes)
    amplitude = np.tile(numeric(model.mj, "gear_error", N_HARMONICS), (model.n_axes, 1))
    return amplitude, np.column_stack([once, 2.0 * once, gear, 2.0 * gear])


def gear_phases(model: RobotModel) -> Array:
    """Phases of the transmission error in a robot's file, (n, 4) [rad]."""
    size = model.n_axes * N_HARMONICS
    return numeric(model.mj, "gear_error_phase", size).reshape(-1, N_HARMONICS)


# Bittencourt's model of an ABB axis, identified on axis 2 of an IRB6620 (26 N m), relative to the
# peak torque: robot-data 3.3 after Yan, Li, Meng 2020.
_FC0, _FCL, _FSL, _FS0, _FST, _FV0, _FVT = 0.0311, 0.0234, 0.126, -0.025, 0.0016, 1.3e-4, 1.32e-3


TEMPERATURES = (26.0, 80.0)
"""[deg C], range of the law: its Stribeck speed vanishes at 25.3; 80 is an ESTIMATE."""


def load_friction(load: Array, temperature: float) -> tuple[Array, Array, float, float]:
    """Friction of a drive at a load, both relative to the peak torque: Coulomb and static, shape of
    `load`; viscous [s/rad]; Stribeck speed [rad/s]. temperature: [deg C], of the gear."""
    load = np.abs(load)
    coulomb = _FC0 + _FCL * load
    static = coulomb + _FSL * load + _FS0 + _FST * temperature
    viscous = _FV0 + _FVT * np.exp(-temperature / 20.71)
    return coulomb, static, viscous, -24.81 + 0.98 * temperature


def _set_load_friction(
    model: RobotModel, phi: Array, factors: FrictionFactors, temperature: float | None
) -> None:
    mj, limit = model.mj, model.drives.torque_limit
    warm = scalar(mj, "gear_temperature") if temperature is None else temperature
    holding = Statics(model).equilibrium(phi).holding_torque
    load = holding / model.drives.gear / limit  # of the peak torque of each drive
    coulomb, static, viscous, stribeck = load_friction(load, warm)
    scale = numeric(mj, "load_friction_scale", model.n_axes)
    excess = scalar(mj, "load_friction_static") * (static - coulomb) * factors.static_excess
    coulomb = coulomb + (_FC0 * (factors.constant - 1.0))
    coulomb = coulomb + _FCL * np.abs(load) * (factors.load - 1.0)
    static = coulomb + excess
    for i, axis in enumerate(axis_actuators(mj)):
        mj.actuator_biasprm[axis, _COULOMB] = scale[i] * coulomb[i] * limit[i]
        mj.actuator_biasprm[axis, _STATIC] = scale[i] * static[i] * limit[i]
        mj.actuator_biasprm[axis, _STRIBECK] = stribeck
        mj.actuator_damping[axis] = viscous * limit[i]
