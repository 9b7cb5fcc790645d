"""Hardware of a robot as far as its file states it: keys, ranges, and a report of estimates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from ..cell import Taken

Values = Mapping[str, tuple[float, ...]]
"""Numbers by the key of the file: one for each axis, or as many as the key has."""
Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class LinkBody:
    """Mass of one link, base or tool; None is estimated."""

    mass: float | None = None
    """[kg]."""
    centre: Vector | None = None
    """Centre of mass [m]."""
    inertia: tuple[float, float, float, float, float, float] | None = None
    """xx, yy, zz, xy, xz, yz about the centre of mass [kg m^2]."""


@dataclass(frozen=True, kw_only=True)
class StructureHinge:
    """Elastic hinge of the structure, in the axes of the link it lies on."""

    name: str
    link: int
    """Moving link from 1, behind its gear; 0: the base, before the first motor."""
    direction: Vector
    point: Vector
    """[m]."""
    stiffness: float
    """[N m/rad]."""
    damping: float | None
    """[N m s/rad]; None: from the damping ratio."""
    damping_ratio: float


@dataclass(frozen=True, kw_only=True)
class Hardware:
    """Tables of a robot file that describe its hardware."""

    mass: float | None = None
    """Of the whole robot with its base, without the tool [kg]."""
    timestep: float = 0.0005
    """Physics step [s]."""
    base: LinkBody = LinkBody()
    bodies: tuple[LinkBody, ...] = ()
    """One for each moving link, in the axes of its D-H frame; none: all estimated."""
    tool: LinkBody = LinkBody()
    """In the axes of the tool frame."""
    drives: Values = field(default_factory=dict)
    gears: Values = field(default_factory=dict)
    rigid: bool = False
    """Gears without springs."""
    effects: Values = field(default_factory=dict)
    structure: tuple[StructureHinge, ...] = ()


EACH = 0
"""Size of a key with one number for each axis; one number alone is that of every axis."""
PHASES = -1
"""Size of the phases of the transmission error: four for each axis."""


@dataclass(frozen=True)
class Key:
    """Numbers that a key takes."""

    size: int
    unit: str
    meaning: str
    default: str
    """Rule of the default, for the report and the docs."""
    low: float = 0.0
    strict: bool = True
    """Numbers must be above `low`; otherwise they may be equal to it."""
    high: float = 1e12


DRIVES: Mapping[str, Key] = {
    "gear_ratio": Key(EACH, "", "motor over arm-side angle; [rad/m] for a prismatic axis",
                      "100; a lead of 20 mm a turn"),
    "torque_limit": Key(EACH, "N m", "peak torque of the drive",
                        "twice the greatest load of gravity, and twice inertia times speed "
                        "limit over 0.2 s"),
    "rotor_inertia": Key(EACH, "kg m^2", "of the rotor, on the motor side",
                         "1.7e-4 s^2 times the torque limit on the motor side"),
    "speed_limit": Key(EACH, "rad/s", "of the drive", "that of [limits]"),
    "encoder_counts": Key(1, "", "counts a turn of the motor", "16384"),
    "encoder_noise": Key(1, "counts", "rms, white", "0", strict=False),
    "coulomb_friction": Key(EACH, "N m", "Coulomb friction", "0.05 of the torque limit",
                            strict=False),
    "static_friction": Key(EACH, "N m", "static friction", "1.14 of the Coulomb friction",
                           strict=False),
    "stribeck_speed": Key(EACH, "rad/s", "Stribeck speed", "15 rad/s of the motor"),
    "viscous_friction": Key(EACH, "N m s/rad", "viscous friction",
                            "4.4e-4 s/rad of the torque limit, by motor speed", strict=False),
    "bandwidth": Key(EACH, "Hz", "undamped frequency of the servo",
                     "6.4, at most 0.75 of the lowest mode"),
    "servo_damping": Key(EACH, "", "damping ratio of the servo", "1.15"),
    "position_gain": Key(EACH, "N m/rad", "gain on the position error",
                         "total inertia times (2 pi bandwidth)^2"),
    "integral_gain": Key(EACH, "N m/(rad s)", "gain on its integral", "0", strict=False),
    "velocity_gain": Key(EACH, "N m s/rad", "gain on the speed error",
                         "2 servo_damping times total inertia times 2 pi bandwidth"),
    "velocity_feedforward": Key(EACH, "", "fraction of the reference speed fed forward", "0.9",
                                strict=False),
    "torque_feedforward": Key(1, "", "fraction of the rigid torque fed forward", "1",
                              strict=False),
    "friction_feedforward": Key(1, "", "fraction of friction fed forward", "0", strict=False),
    "correction_delay": Key(1, "s", "delay of a correction", "0.0138", strict=False),
    "correction_lag": Key(1, "Hz", "corner frequency of a correction's lag", "28.5"),
    "elastic_compensation": Key(1, "", "fraction of the elastic deflection in the reference", "0",
                                strict=False),
    "torque_noise": Key(2, "Hz", "rms over the torque limit, and bandwidth", "1e-4, 20",
                        strict=False),
}  # fmt: skip
"""ESTIMATE, each default: those of the large robot in proportion, and round."""

GEARS: Mapping[str, Key] = {
    "stiffness": Key(EACH, "N m/rad", "of the gear's spring",
                     "torque limit over 1/300 rad, or 0.1 mm of a prismatic axis; at "
                     "most 150 Hz alone"),
    "frequency": Key(EACH, "Hz", "of the arm on the gear's spring, motors held, in place of the "
                     "stiffness", ""),
    "damping": Key(EACH, "N m s/rad", "of the gear's damper", "from the damping ratio"),
    "damping_ratio": Key(EACH, "", "of the arm on the gear's spring", "0.03"),
}  # fmt: skip
"""ESTIMATE, each default, after the large robot: 290 to 620 rad^-1, 0.03."""

EFFECTS: Mapping[str, Key] = {
    "lost_motion": Key(EACH, "rad", "half of the soft region of a gear", "none"),
    "soft_stiffness": Key(EACH, "N m/rad", "in the soft region", "a sixth of the stiffness"),
    "gear_error": Key(4, "rad", "amplitudes of the transmission error at 1 and 2 times the output "
                      "and the motor angle", "none", strict=False),
    "gear_error_phase": Key(PHASES, "rad", "its phases, four for each axis", "drawn, the same each "
                            "time", low=-1e3),
    "torque_ripple": Key(2, "", "over the torque limit, and order in motor angle", "none",
                         strict=False),
    "load_friction_scale": Key(EACH, "", "factor on the friction law of load and temperature",
                               "none"),
    "load_friction_static": Key(1, "", "factor on its excess of static friction", "1",
                                strict=False),
    "gear_temperature": Key(1, "deg C", "temperature of that law", "33", low=26.0,
                            strict=False, high=80.0),
}  # fmt: skip
"""An effect that is not given is absent."""
NEEDED: Mapping[str, str] = {
    "soft_stiffness": "lost_motion",
    "gear_error_phase": "gear_error",
    "load_friction_static": "load_friction_scale",
    "gear_temperature": "load_friction_scale",
}
"""Keys of [effects] without meaning where another is not given."""


PER_CUBE = 40.0
"""[kg/m^3], mass of a robot over its stretched length cubed: industrial arms have 38 to 67, arms
for work beside people 8 to 14. ESTIMATE."""
BASE = 0.2
"""Fraction of a robot's mass in its base. ESTIMATE."""
LEAST = 0.05
"""Length that each link weighs at least, over the stretched length. ESTIMATE."""
TOOL = 0.02
"""Mass of the tool over that of the robot. ESTIMATE."""
DIGITS = 4
"""Digits of an estimated number: the same model on every machine."""


@dataclass
class Report:
    """Estimates in the order in which they are made."""

    taken: list[Taken] = field(default_factory=list)

    def take(
        self, name: str, values: Sequence[float] | Array, rule: str, *, exact: bool = False
    ) -> Array:
        """Note estimated numbers, and return them, rounded unless they are exact."""
        given = np.asarray(values, dtype=np.float64)
        found = given if exact else rounded(given)
        self.taken.append(Taken(name, tuple(np.atleast_1d(found).tolist()), rule))
        return found


def rounded(values: Array) -> Array:
    """Numbers with `DIGITS` digits."""
    return np.array([float(f"{v:.{DIGITS}g}") for v in values.ravel()]).reshape(values.shape)
