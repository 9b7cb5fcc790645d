"""Text of the MJCF of a robot, with the names that every robot of the project has."""

from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike

from .bodies_text import Tree, worldbody
from .description import Hardware
from .drives import Drives
from .text import number, row

_BRISTLE, _BRISTLE_DAMPING = 0.76923077, 0.011538462
"""LuGre stiffness [1/rad] and damping [s/rad] of the motor over its peak torque: the large robot's,
whose calibration found them. ESTIMATE."""
_SOFT = 1.0 / 6.0
"""Soft over full stiffness of a gear: benchmark of Moberg, Ohr and Gunnarsson, as the large robot.
"""
_N_HARMONICS = 4


def rigid_text(tree: Tree, given: Hardware) -> str:
    """MJCF of the arm with rigid gears and without drives."""
    return "\n".join([*_head("rigid", given), *_defaults(), *worldbody(tree), "</mujoco>", ""])


def full_text(name: str, comment: str, tree: Tree, given: Hardware, drives: Drives) -> str:
    """MJCF of the virtual hardware."""
    n = len(tree.chain)
    lines = [
        *_head(name, given, comment),
        *_custom(given, drives, n),
        *_defaults(),
        *worldbody(tree),
        *(_tendons(n) if "lost_motion" in given.effects else []),
        *_actuators(drives, n),
        *_sensors(n),
        "  <keyframe>",
        '    <key name="zero"/>',
        "  </keyframe>",
        "</mujoco>",
        "",
    ]
    return "\n".join(lines)


def _head(name: str, given: Hardware, comment: str = "") -> list[str]:
    option = f'timestep="{number(given.timestep)}" integrator="implicitfast"'
    return [
        *([f"<!--\n{comment}\n-->"] if comment else []),
        f"<mujoco model={quoteattr(name)}>",
        '  <compiler angle="radian" autolimits="true" inertiafromgeom="false"/>',
        f'  <option {option} gravity="0 0 -9.82"/>',
        '  <size nkey="1"/>',
    ]


def _custom(given: Hardware, drives: Drives, n: int) -> list[str]:
    numerics = {
        name: drives[name]
        for name in (
            *("gear_ratio", "speed_limit", "encoder_counts", "encoder_noise"),
            *("velocity_feedforward", "torque_feedforward", "friction_feedforward"),
            *("correction_delay", "correction_lag", "elastic_compensation", "torque_noise"),
        )
    }
    lines = [f'    <numeric name="{k}" data="{row(v)}"/>' for k, v in numerics.items()]
    for name, values in _effects(given, drives, n).items():
        lines.append(f'    <numeric name="{name}" data="{row(values)}"/>')
    return ["  <custom>", *lines, "  </custom>"]


def _effects(given: Hardware, drives: Drives, n: int) -> dict[str, ArrayLike]:
    """Numerics of the effects that the file gives."""
    asked, found = given.effects, dict[str, ArrayLike]()
    if "lost_motion" in asked:
        soft = asked.get("soft_stiffness", tuple(_SOFT * drives.stiffness))
        found |= {"gear_soft_stiffness": soft, "gear_lost_motion": asked["lost_motion"]}
    if "gear_error" in asked:
        drawn = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, n * _N_HARMONICS).round(3)
        found["gear_error"] = asked["gear_error"]
        found["gear_error_phase"] = asked.get("gear_error_phase", drawn)
    if "torque_ripple" in asked:
        found["torque_ripple"] = asked["torque_ripple"]
    if "load_friction_scale" in asked:
        found["load_friction_scale"] = asked["load_friction_scale"]
        found["load_friction_static"] = asked.get("load_friction_static", (1.0,))
        found["gear_temperature"] = asked.get("gear_temperature", (33.0,))
    return found


def _defaults() -> list[str]:
    return [
        "  <default>",
        '    <default class="robot">',
        '      <geom contype="0" conaffinity="0" group="2"/>',
        '      <joint type="hinge"/>',
        '      <site group="4" size="0.01" rgba="0.1 0.6 0.9 1"/>',
        '      <tendon group="4"/>',
        '      <default class="motor">',
        '        <joint group="1"/>',
        '        <dcmotor input="pos vel ff" motorconst="1 1" resistance="1"/>',
        "      </default>",
        '      <default class="flex"><joint group="3"/></default>',
        '      <default class="struct"><joint group="3"/></default>',
        "    </default>",
        "  </default>",
        "  <asset>",
        '    <material name="shell" rgba="0.80 0.81 0.83 1" specular="0.5" shininess="0.6"/>',
        '    <material name="joint" rgba="0.20 0.36 0.56 1" specular="0.3" shininess="0.4"/>',
        '    <material name="tool" rgba="0.93 0.60 0.12 1" specular="0.4" shininess="0.5"/>',
        "  </asset>",
    ]


def _tendons(n: int) -> list[str]:
    lines = ["  <tendon>"]
    for i in range(1, n + 1):
        lines.append(f'    <fixed name="gear_{i}" class="robot" springlength="0 0">')
        lines += [f'      <joint joint="flex_{i}" coef="1"/>', "    </fixed>"]
    return [*lines, "  </tendon>"]


def _actuators(drives: Drives, n: int) -> list[str]:
    """Drives in motor units: torques over the ratio, gains and dampers over its square."""
    ratio = drives["gear_ratio"]
    peak = drives["torque_limit"] / ratio
    kp, ki, kd = (
        drives[f"{name}_gain"] / ratio**2 for name in ("position", "integral", "velocity")
    )
    coulomb, static = drives["coulomb_friction"] / ratio, drives["static_friction"] / ratio
    stribeck, viscous = drives["stribeck_speed"] * ratio, drives["viscous_friction"] / ratio**2
    lines = [
        "  <!-- motor units: peak torque [N m], gains kp ki kd, LuGre friction -->",
        "  <actuator>",
    ]
    for i in range(n):
        gains = row([kp[i], ki[i], kd[i], 0, 0, 0])
        lugre = row(
            [_BRISTLE * peak[i], _BRISTLE_DAMPING * peak[i], coulomb[i], static[i], stribeck[i]]
        )
        lines.append(
            f'    <dcmotor name="axis_{i + 1}" class="motor" joint="motor_{i + 1}" '
            f'gear="{number(ratio[i])}" saturation="{number(peak[i])} 0 0" '
            f'damping="{number(viscous[i])}" controller="{gains}" lugre="{lugre}"/>'
        )
    return [*lines, "  </actuator>"]


def _sensors(n: int) -> list[str]:
    axes = range(1, n + 1)
    return [
        "  <sensor>",
        *(f'    <jointpos name="axis_{i}_pos" joint="motor_{i}"/>' for i in axes),
        *(f'    <actuatorfrc name="axis_{i}_torque" actuator="axis_{i}"/>' for i in axes),
        '    <accelerometer name="imu_acc" site="imu"/>',
        '    <gyro name="imu_gyro" site="imu"/>',
        '    <framepos name="tool0_pos" objtype="site" objname="tool0"/>',
        '    <framequat name="tool0_quat" objtype="site" objname="tool0"/>',
        "  </sensor>",
    ]
