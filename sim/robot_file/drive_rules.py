"""Drives and gears, complete: those of the file, the others from masses, limits and each other.

Arm side of the gear, but the rotor's inertia. See `armside.sim.robot_file.hardware` for the rules.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from armside.arrays import Array
from armside.kinematics import Joint, Limits

from ..robot.mjcf import mass_matrix
from .body_frames import Frame
from .hardware import DRIVES, GEARS, Hardware, Report

_DRAWN = 100
"""Random configurations within the limits."""


@dataclass(frozen=True, eq=False)
class RigidArm:
    """A compiled arm with the joints motor_1..n alone, without rotors and springs."""

    mj: mujoco.MjModel
    home: Array
    """(n,) [rad], motor angles at which inertia and modes are taken."""
    limits: Limits

    @cached_property
    def mass_matrix(self) -> Array:
        """(n, n) [kg m^2] at home."""
        return mass_matrix(self.mj, self.home)

    @property
    def inertia(self) -> Array:
        """(n,) [kg m^2] that each motor moves at home, the other axes held."""
        return np.diag(self.mass_matrix).copy()

    @cached_property
    def gravity_load(self) -> Array:
        """(n,) [N m], greatest load of gravity at home and in random configurations."""
        rng, data = np.random.default_rng(0), mujoco.MjData(self.mj)
        drawn = rng.uniform(self.limits.lower, self.limits.upper, (_DRAWN, len(self.home)))
        load = np.zeros(len(self.home))
        for q in (self.home, *drawn[self.limits.contain(drawn)]):
            data.qpos[:], data.qvel[:], data.qacc[:] = q, 0.0, 0.0
            mujoco.mj_inverse(self.mj, data)
            load = np.maximum(load, np.abs(data.qfrc_inverse))
        return load

    def lowest_mode(self, stiffness: Array) -> float:
        """Lowest natural frequency [Hz] at home on gear springs (n,); infinite without any."""
        from scipy.linalg import eigh

        if not len(stiffness):
            return np.inf
        omega_squared = eigh(np.diag(stiffness), self.mass_matrix, eigvals_only=True)
        return float(np.sqrt(max(omega_squared[0], 0.0)) / (2.0 * np.pi))


GEAR, LEAD = 100.0, 2.0 * np.pi / 0.020
RISE = 0.2
"""[s] from rest to full speed. ESTIMATE."""
LEAST_TORQUE = 0.03
"""Of the largest drive, where neither gravity nor inertia asks for more. ESTIMATE."""
ROTOR = 1.7e-4
"""[s^2], inertia of a rotor over its peak torque: 1.5 to 1.8e-4 on the large robot. ESTIMATE."""
COULOMB, STATIC, STRIBECK, VISCOUS = 0.05, 1.14, 15.0, 4.4e-4
BANDWIDTH, BELOW_MODE, SERVO_DAMPING = 6.4, 0.75, 1.15
STIFFNESS, OF_SLIDE, STIFFEST, DAMPING = 300.0, 1e4, 150.0, 0.03
"""[1/rad], [1/m], [Hz] and damping ratio."""


@dataclass(frozen=True)
class Drives:
    """Numbers of the drives by the key of the file, arrays (n,) or numbers; gears beside them."""

    values: dict[str, Array]
    stiffness: Array
    damping: Array
    """(n,), empty for rigid gears."""

    def __getitem__(self, name: str) -> Array:
        return self.values[name]

    def one(self, name: str) -> float:
        """A number for all axes."""
        return float(self.values[name][0])


def drives(
    given: Hardware, chain: list[Frame], limits: Limits, arm: RigidArm, report: Report
) -> Drives:
    """Drives and gears of a robot, completed. Estimates are noted in `report`."""
    n, found = len(chain), dict[str, Array]()

    def take(name: str, rule: Callable[[], Array | float]) -> None:
        if name in given.drives:
            found[name] = np.array(given.drives[name])
            return
        size = DRIVES[name].size or n
        values = np.broadcast_to(np.asarray(rule(), dtype=np.float64), (size,))
        text = f"ESTIMATE: {DRIVES[name].default}"
        found[name] = report.take(f"drives: {name}", values, text, exact=name in _EXACT)

    slides = np.array([frame.joint is Joint.PRISMATIC for frame in chain])

    speed = np.array(limits.speed)
    take("speed_limit", lambda: speed)
    take("gear_ratio", lambda: np.where(slides, LEAD, GEAR))

    def torque() -> Array:
        needed = 2.0 * (arm.gravity_load + arm.inertia * speed / RISE)
        return np.maximum(needed, LEAST_TORQUE * needed.max())

    take("torque_limit", torque)
    ratio, peak = found["gear_ratio"], found["torque_limit"]
    take("rotor_inertia", lambda: ROTOR * peak / ratio)
    take("encoder_counts", lambda: 16384.0)
    take("encoder_noise", lambda: 0.0)
    take("coulomb_friction", lambda: COULOMB * peak)
    take("static_friction", lambda: STATIC * found["coulomb_friction"])
    static, coulomb = found["static_friction"], found["coulomb_friction"]
    if (lower := np.flatnonzero(static < coulomb)).size:
        i = int(lower[0])
        raise ValueError(
            f"drives: static_friction must be >= coulomb_friction, got {static[i]:g} and "
            f"{coulomb[i]:g} N m on axis {i + 1}"
        )
    take("stribeck_speed", lambda: STRIBECK / ratio)
    take("viscous_friction", lambda: VISCOUS * peak * ratio)
    per_torque = np.where(slides, OF_SLIDE, STIFFNESS)
    stiffness = _stiffness(given, per_torque * peak, arm, report)
    total = ratio**2 * found["rotor_inertia"] + arm.inertia
    take("bandwidth", lambda: min(BANDWIDTH, BELOW_MODE * arm.lowest_mode(stiffness)))
    take("servo_damping", lambda: SERVO_DAMPING)
    omega = 2.0 * np.pi * found["bandwidth"]
    take("position_gain", lambda: total * omega**2)
    take("integral_gain", lambda: 0.0)
    take("velocity_gain", lambda: 2.0 * found["servo_damping"] * total * omega)
    for name, value in _CONTROLLER.items():
        take(name, lambda value=value: np.array(value))
    return Drives(found, stiffness, _damping(given, stiffness, arm, report))


_EXACT = ("speed_limit", "gear_ratio", "encoder_counts")
_CONTROLLER = {
    "velocity_feedforward": 0.9,
    "torque_feedforward": 1.0,
    "friction_feedforward": 0.0,
    "correction_delay": 0.0138,
    "correction_lag": 28.5,
    "elastic_compensation": 0.0,
    "torque_noise": (1e-4, 20.0),
}
"""ESTIMATE: after the large robot."""


def _stiffness(given: Hardware, usual: Array, arm: RigidArm, report: Report) -> Array:
    if given.rigid:
        return np.zeros(0)
    if "stiffness" in given.gears:
        return np.array(given.gears["stiffness"])
    if "frequency" in given.gears:
        values = arm.inertia * (2.0 * np.pi * np.array(given.gears["frequency"])) ** 2
        rule = "inertia of the arm at home times (2 pi frequency)^2"
        return report.take("gears: stiffness", values, rule)
    # The inertia that each motor feels at home, the other axes free: the smallest.
    own = 1.0 / np.diag(np.asarray(np.linalg.inv(arm.mass_matrix), dtype=np.float64))
    values = np.minimum(usual, own * (2.0 * np.pi * STIFFEST) ** 2)
    return report.take("gears: stiffness", values, f"ESTIMATE: {GEARS['stiffness'].default}")


def _damping(given: Hardware, stiffness: Array, arm: RigidArm, report: Report) -> Array:
    if given.rigid:
        return np.zeros(0)
    if "damping" in given.gears:
        return np.array(given.gears["damping"])
    rule = "ESTIMATE: damping ratio 0.03 of the arm at home"
    ratio = np.full(len(stiffness), DAMPING)
    if "damping_ratio" in given.gears:
        ratio = np.array(given.gears["damping_ratio"])
        rule = "2 damping_ratio times the root of stiffness times inertia of the arm at home"
    return report.take("gears: damping", 2.0 * ratio * np.sqrt(stiffness * arm.inertia), rule)
