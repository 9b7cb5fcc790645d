"""Calibrated quantities of the large robot, as factors on values of the sources, and their file.

`numbers` computes every number of the MJCF that calibration sets from a `Trim` and the reference
data below; `rewrite` puts them into the text of the file, so that the file can be made again.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from armside.arrays import Array

# robot-data 2.1: gears after Moberg, Ohr and Gunnarsson (axis 1), scaled to the others: ESTIMATE
GEAR_STIFFNESS = np.array([3.4e6, 3.4e6, 2.0e6, 4.5e5, 4.0e5, 3.0e5])  # [Nm/rad]
GEAR_DAMPING = np.array([3900.0, 3900.0, 2300.0, 110.0, 200.0, 50.0])  # [Nms/rad]
LOST_MOTION = np.deg2rad(np.array([1.0, 1.0, 1.0, 1.2, 1.2, 1.5]) / 60.0)  # [rad], catalogue limits
STRUCTURE = {  # [Nm/rad], [Nms/rad]: ESTIMATE around the benchmark's k2, k3
    "struct_tilt_x": (8e6, 5400.0),
    "struct_tilt_y": (8e6, 5400.0),
    "struct_lower_bend_x": (4e6, 3400.0),
    "struct_lower_twist_z": (2.5e6, 2100.0),
    "struct_elbow_torsion_x": (1e6, 330.0),
    "struct_elbow_lateral_z": (2e6, 1300.0),
}
# robot-data 3.4, amplitudes at 1 and 2 times the output, 1 and 2 times the motor angle: ESTIMATE
GEAR_ERROR = np.deg2rad(np.array([5.0, 15.0, 5.0, 2.5]) / 3600.0)  # [rad]
RIPPLE = 0.005  # of the peak torque: ESTIMATE
GEAR = np.array([220.0, 242.73, 242.73, 145.0, 180.0, 100.0])
ROTOR_INERTIA = np.array([5.0e-3, 5.9e-3, 4.0e-3, 1.6e-3, 1.2e-3, 0.9e-3])  # [kgm2]
ARM_INERTIA = np.array([700.0, 875.0, 268.0, 2.7, 9.5, 0.8])  # [kgm2], around p2, 40 kg tool
PEAK_TORQUE = np.array([30.0, 32.0, 26.0, 9.0, 8.0, 5.0])  # [motor Nm]


@dataclass(frozen=True, kw_only=True)
class Trim:
    """The calibrated quantities. Factors are on the reference data of this module."""

    servo_frequency: tuple[float, ...] = (6.5, 6.0, 3.8, 8.75, 10.8, 10.3)
    """[Hz], each axis."""
    servo_damping: float
    """Damping ratio of the servo on the rigid joint."""
    velocity_feedforward: tuple[float, ...]
    """Fraction of the reference velocity, each axis."""
    correction_delay: float
    """[s]."""
    elastic_compensation: float
    """Fraction of the quasi-static deflection."""
    gear_stiffness: float
    gear_damping: float
    gear_soft: float
    """Stiffness inside the lost motion over that outside."""
    lost_motion: float
    structure_stiffness: float
    structure_damping: float
    gear_error: float
    ripple: float
    friction: tuple[float, ...]
    """Over the load- and temperature-dependent data, each axis."""
    static_excess: float
    """Static over Coulomb friction, the excess over that of the data."""
    temperature: float
    """[deg C], of the gears."""
    bristle_stiffness: float
    """[Nm/rad] at 26 Nm peak torque, scaled with it: LuGre sigma0."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = np.asarray(getattr(self, field.name), dtype=np.float64)
            if not (np.isfinite(value).all() and (value >= 0.0).all()):
                raise ValueError(f"{field.name} must be >= 0, got {getattr(self, field.name)}")


@dataclass(frozen=True)
class Numbers:
    """Numbers of the file that a trim sets: springs, actuators and custom numerics by name."""

    springs: Mapping[str, tuple[float, float]]
    """Joint: stiffness [Nm/rad], damping [Nms/rad]."""
    controllers: Array
    """(6, 2): kp [Nm/rad], kd [Nms/rad], motor side."""
    bristles: Array
    """(6, 2): sigma0 [Nm/rad], sigma1 [Nms/rad], motor side."""
    numerics: Mapping[str, Array]


def numbers(trim: Trim) -> Numbers:
    """Every number of the file that a trim sets."""
    w0 = 2.0 * np.pi * np.array(trim.servo_frequency)
    inertia = GEAR**2 * ROTOR_INERTIA + ARM_INERTIA
    kp = inertia * w0**2 / GEAR**2
    kd = 2.0 * trim.servo_damping * inertia * w0 / GEAR**2
    size = PEAK_TORQUE / 26.0
    stiffness = trim.gear_stiffness * GEAR_STIFFNESS
    gears = zip(stiffness, trim.gear_damping * GEAR_DAMPING, strict=True)
    springs = {f"flex_{i}": spring for i, spring in enumerate(gears, 1)}
    for name, (k, d) in STRUCTURE.items():
        springs[name] = trim.structure_stiffness * k, trim.structure_damping * d
    return Numbers(
        springs=springs,
        controllers=np.column_stack([kp, kd]),
        bristles=np.column_stack([trim.bristle_stiffness * size, 0.3 * size]),
        numerics={
            "velocity_feedforward": np.array(trim.velocity_feedforward),
            "correction_delay": np.array([trim.correction_delay]),
            "elastic_compensation": np.array([trim.elastic_compensation]),
            "gear_soft_stiffness": trim.gear_soft * stiffness,
            "gear_lost_motion": 0.5 * trim.lost_motion * LOST_MOTION,
            "gear_error": trim.gear_error * GEAR_ERROR,
            "torque_ripple": np.array([trim.ripple * RIPPLE, 12.0]),
            "load_friction_scale": np.array(trim.friction),
            "load_friction_static": np.array([trim.static_excess]),
            "gear_temperature": np.array([trim.temperature]),
        },
    )


def compiled(file: Path, trim: Trim) -> mujoco.MjModel:
    """The model of an MJCF of the large robot with the numbers of a trim."""
    return mujoco.MjModel.from_xml_string(rewrite(file.read_text(encoding="utf-8"), trim))


def differing(file: Path, trim: Trim) -> list[str]:
    """Names of the quantities that an MJCF has otherwise than a trim."""
    mj, wanted = mujoco.MjModel.from_xml_path(str(file)), compiled(file, trim)
    read: dict[str, Callable[[mujoco.MjModel], Any]] = {
        "springs": lambda of: np.append(of.jnt_stiffness, of.dof_damping),
        "controllers": lambda of: of.actuator_gainprm,
        "friction": lambda of: of.actuator_dynprm,
    } | {name: lambda of, name=name: of.numeric(name).data for name in numbers(trim).numerics}
    return [name for name, of in read.items() if not np.allclose(of(mj), of(wanted), rtol=1e-6)]


def rewrite(text: str, trim: Trim) -> str:
    """The text of the MJCF with the numbers of a trim, everything else as it was."""
    found = numbers(trim)
    for name, (stiffness, damping) in found.springs.items():
        text = _set(text, "joint", name, "stiffness", [stiffness])
        text = _set(text, "joint", name, "damping", [damping])
    for i in range(6):
        kp, kd = found.controllers[i]
        name = f"axis_{i + 1}"
        text = _set(text, "dcmotor", name, "controller", [kp, 0.0, kd, 0.0, 0.0, 0.0])
        text = _set(text, "dcmotor", name, "lugre", found.bristles[i])
    for name, values in found.numerics.items():
        text = _set(text, "numeric", name, "data", values)
    return text


def _set(text: str, tag: str, name: str, attribute: str, values: "Array | list[float]") -> str:
    """Replace the first numbers of an attribute of the element of that name."""
    element = re.search(rf'<{tag}\s[^>]*name="{name}"[^>]*>', text)
    if element is None:
        raise ValueError(f"the file has no {tag} named {name}")
    written = re.search(rf'(\s{attribute}=")([^"]*)"', element.group())
    if written is None:
        raise ValueError(f"{tag} {name} has no {attribute}")
    words = written.group(2).split()
    words[: len(values)] = [f"{value:.8g}" for value in values]
    start = element.start() + written.start(2)
    return text[:start] + " ".join(words) + text[start + len(written.group(2)) :]
