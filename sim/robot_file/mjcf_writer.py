"""MJCF of a robot with its hardware, and the names that every robot of the project has.

The document is a tree of `xml.etree`. `mujoco.MjSpec` builds the same model, but what it writes has
six digits a number, no comments (the sources of the numbers), and drives as bare parameters.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.kinematics import Joint, Limits

from ..robot.drives import N_HARMONICS
from .body_frames import Frame, points
from .drive_rules import Drives
from .hardware import Hardware, StructureHinge
from .masses import Mass, Masses, cylinder

_ROUNDING = 15
"""Decimals; rounding of a right angle leaves 6e-17."""
_BRISTLE, _BRISTLE_DAMPING = 0.76923077, 0.011538462
"""LuGre stiffness [1/rad] and damping [s/rad] of the motor over its peak torque: the large robot's,
whose calibration found them. ESTIMATE."""
_SOFT = 1.0 / 6.0
"""Soft over full stiffness of a gear: benchmark of Moberg, Ohr and Gunnarsson, as the large robot.
"""
_NUMERICS = (
    *("gear_ratio", "speed_limit", "encoder_counts", "encoder_noise"),
    *("velocity_feedforward", "torque_feedforward", "friction_feedforward"),
    *("correction_delay", "correction_lag", "elastic_compensation", "torque_noise"),
)
"""Keys of the drives that the model has as custom numerics."""
_MATERIALS = {
    "shell": ("0.80 0.81 0.83 1", "0.5", "0.6"),
    "joint": ("0.20 0.36 0.56 1", "0.3", "0.4"),
    "tool": ("0.93 0.60 0.12 1", "0.4", "0.5"),
}
"""Colour, specular and shininess."""


class Spring(NamedTuple):
    """Spring and damper of a joint."""

    stiffness: float
    damping: float


@dataclass(frozen=True, eq=False)
class Tree:
    """All that the bodies of an MJCF are written from."""

    chain: list[Frame]
    masses: Masses
    limits: Limits
    armature: Sequence[float] | Array
    """(n,) [kg m^2]."""
    gears: Sequence[Spring]
    """(n,), or none: rigid gears."""
    structure: Sequence[tuple[StructureHinge, Spring]]
    imu: Array
    """(4, 4), in the tool frame."""
    estimates: tuple[str, str] = ("", "")
    """Words of the comments at armatures and springs."""


def rigid_mjcf(tree: Tree, given: Hardware) -> str:
    """MJCF of the arm with rigid gears and without drives."""
    root = _head("rigid", given)
    _add_defaults(root)
    _add_bodies(root, tree)
    return _text(root)


def full_mjcf(name: str, comment: str, tree: Tree, given: Hardware, drives: Drives) -> str:
    """MJCF of the virtual hardware, with a comment before it."""
    n, root = len(tree.chain), _head(name, given)
    custom = SubElement(root, "custom")
    values = {key: drives[key] for key in _NUMERICS} | _effects(given, drives, n)
    for key, data in values.items():
        SubElement(custom, "numeric", name=key, data=row(data))
    _add_defaults(root)
    _add_bodies(root, tree)
    if "lost_motion" in given.effects:  # stiff parts of gears, over the springs of their joints
        tendons = SubElement(root, "tendon")
        for i in range(1, n + 1):
            of_gear = {"name": f"gear_{i}", "class": "robot", "springlength": "0 0"}
            SubElement(SubElement(tendons, "fixed", of_gear), "joint", joint=f"flex_{i}", coef="1")
    _add_actuators(root, drives, n)
    _add_sensors(root, n)
    SubElement(SubElement(root, "keyframe"), "key", name="zero")
    return f"<!--\n{comment}\n-->\n{_text(root)}"


def number(value: float) -> str:
    """Shortest text of a number that reads back as the same."""
    short = round(float(value), _ROUNDING) if abs(value) < 1.0 else float(value)
    return repr(int(short)) if short == int(short) and abs(short) < 1e15 else repr(short)


def row(values: ArrayLike | Iterable[float]) -> str:
    """Numbers with spaces between."""
    return " ".join(number(value) for value in np.atleast_1d(np.asarray(values)).ravel().tolist())


def pose(T: Array) -> dict[str, str]:
    """Attributes pos and quat of a transform (4, 4), none for the identity."""
    found = dict[str, str]()
    if np.abs(T[:3, 3]).max() > 1e-15:
        found["pos"] = row(T[:3, 3])
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(T[:3, :3]).ravel())
    if abs(abs(quaternion[0]) - 1.0) > 1e-15:
        found["quat"] = row(quaternion)
    return found


def _text(root: Element) -> str:
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def _head(name: str, given: Hardware) -> Element:
    root = Element("mujoco", model=name)
    SubElement(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
    step, gravity = number(given.timestep), "0 0 -9.82"
    SubElement(root, "option", timestep=step, integrator="implicitfast", gravity=gravity)
    SubElement(root, "size", nkey="1")
    return root


def _effects(given: Hardware, drives: Drives, n: int) -> dict[str, ArrayLike]:
    asked, found = given.effects, dict[str, ArrayLike]()
    if "lost_motion" in asked:
        soft = asked.get("soft_stiffness", tuple(_SOFT * drives.stiffness))
        found |= {"gear_soft_stiffness": soft, "gear_lost_motion": asked["lost_motion"]}
    if "gear_error" in asked:
        drawn = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, n * N_HARMONICS).round(3)
        found["gear_error"] = asked["gear_error"]
        found["gear_error_phase"] = asked.get("gear_error_phase", drawn)
    if "torque_ripple" in asked:
        found["torque_ripple"] = asked["torque_ripple"]
    if "load_friction_scale" in asked:
        found["load_friction_scale"] = asked["load_friction_scale"]
        found["load_friction_static"] = asked.get("load_friction_static", (1.0,))
        found["gear_temperature"] = asked.get("gear_temperature", (33.0,))
    return found


def _add_defaults(root: Element) -> None:
    robot = SubElement(SubElement(root, "default"), "default", {"class": "robot"})
    SubElement(robot, "geom", contype="0", conaffinity="0", group="2")
    SubElement(robot, "joint", type="hinge")
    SubElement(robot, "site", group="4", size="0.01", rgba="0.1 0.6 0.9 1")
    SubElement(robot, "tendon", group="4")
    for name, group in (("motor", "1"), ("flex", "3"), ("struct", "3")):
        of_joints = SubElement(robot, "default", {"class": name})
        SubElement(of_joints, "joint", group=group)
        if name == "motor":
            SubElement(of_joints, "dcmotor", input="pos vel ff", motorconst="1 1", resistance="1")
    asset = SubElement(root, "asset")
    for name, (rgba, specular, shininess) in _MATERIALS.items():
        look = {"rgba": rgba, "specular": specular, "shininess": shininess}
        SubElement(asset, "material", look, name=name)


def _add_bodies(root: Element, tree: Tree) -> None:
    body = SubElement(SubElement(root, "worldbody"), "body", name="base", childclass="robot")
    _add_mass(body, tree.masses.base)
    _add_base_shape(body, tree)
    for i, frame in enumerate(tree.chain):
        body = SubElement(body, "body", {"name": f"link_{i + 1}"} | pose(frame.place))
        _add_mass(body, tree.masses.links[i])
        _add_joints(body, tree, i)
        _add_shapes(body, frame, tree.masses.links[i])
    end = tree.chain[-1].end
    SubElement(body, "site", {"name": "tool0"} | pose(end))
    box = {"type": "box", "size": "0.02 0.02 0.012"}
    SubElement(body, "site", {"name": "imu"} | pose(end @ tree.imu) | box)
    SubElement(body, "site", {"name": "tracker_target"} | pose(end))
    tool = SubElement(body, "body", {"name": "tool"} | pose(end))
    _add_mass(tool, tree.masses.tool)
    _add_tool_shape(tool, tree.masses.tool)


def _add_mass(body: Element, mass: Mass) -> None:
    body.append(Comment(f" {mass.source} "))
    inertia = row(mass.inertia)
    SubElement(body, "inertial", pos=row(mass.centre), mass=number(mass.mass), fullinertia=inertia)


def _add_joints(body: Element, tree: Tree, i: int) -> None:
    """Motor and gear of an axis, with the hinges of the structure before and behind them."""
    frame = tree.chain[i]
    for hinge, spring in tree.structure:
        if hinge.link == i == 0:
            _add_hinge(
                body, hinge, spring, np.asarray(np.linalg.inv(frame.place), dtype=np.float64)
            )
    along = {"axis": f"0 0 {number(frame.sign)}"}
    if frame.joint is Joint.PRISMATIC:
        along["type"] = "slide"
    motor = along | {"range": row([tree.limits.lower[i], tree.limits.upper[i]])}
    if len(tree.armature):
        motor["armature"] = number(tree.armature[i])
    for name, words, joint in (
        ("motor", tree.estimates[0], motor),
        *([("flex", tree.estimates[1], along | _spring(tree.gears[i]))] if tree.gears else []),
    ):
        if words:
            body.append(Comment(f" {words} "))
        SubElement(body, "joint", {"name": f"{name}_{i + 1}", "class": name} | joint)
    for hinge, spring in tree.structure:
        if hinge.link == i + 1:
            _add_hinge(body, hinge, spring, frame.link)


def _add_hinge(body: Element, hinge: StructureHinge, spring: Spring, T: Array) -> None:
    """A hinge of the structure, whose axes are at T (4, 4) in the body."""
    axis, at = T[:3, :3] @ np.array(hinge.direction), T[:3, :3] @ np.array(hinge.point) + T[:3, 3]
    name = {"name": f"struct_{hinge.name}", "class": "struct"}
    SubElement(body, "joint", name | {"axis": row(axis), "pos": row(at)} | _spring(spring))


def _spring(spring: Spring) -> dict[str, str]:
    return {name: number(value) for name, value in spring._asdict().items()}


def _add_base_shape(body: Element, tree: Tree) -> None:
    x, y, z = points(tree.chain)[0]
    _, radius = cylinder(tree.masses.base.mass, np.array([x, y, z]))
    top, wide = max(float(z), 0.02), min(radius, 0.2 * tree.masses.length + 0.02)
    size, pos = f"{wide:.4g} {top / 2:.4g}", f"{row([x, y])} {top / 2:.4g}"
    SubElement(body, "geom", type="cylinder", size=size, pos=pos, material="joint")


def _add_shapes(body: Element, frame: Frame, mass: Mass) -> None:
    """A drum about the joint and a capsule to the next."""
    _, radius = cylinder(mass.mass, frame.along)
    radius = min(radius, 0.12)
    size = f"{1.15 * radius:.4g} {1.2 * radius:.4g}"
    SubElement(body, "geom", type="cylinder", size=size, material="joint")
    if np.linalg.norm(frame.along) > radius:
        size, to = f"{0.8 * radius:.4g}", f"0 0 0 {row(np.round(frame.along, 6))}"
        SubElement(body, "geom", type="capsule", size=size, fromto=to, material="shell")


def _add_tool_shape(tool: Element, mass: Mass) -> None:
    size = float(np.linalg.norm(mass.centre))
    _, radius = cylinder(mass.mass, np.array([0.0, 0.0, max(2.0 * size, 0.02)]))
    shape = {"type": "sphere", "size": f"{min(radius, 0.1):.4g}"}
    if size >= 1e-3:
        shape |= {"type": "cylinder", "fromto": f"0 0 0 {row(np.round(2.0 * mass.centre, 6))}"}
    SubElement(tool, "geom", shape, material="tool")


def _add_actuators(root: Element, drives: Drives, n: int) -> None:
    """Drives in motor units: torques over the ratio, gains and dampers over its square."""
    ratio = drives["gear_ratio"]
    peak = drives["torque_limit"] / ratio
    kp, ki, kd = (
        drives[f"{name}_gain"] / ratio**2 for name in ("position", "integral", "velocity")
    )
    coulomb, static = drives["coulomb_friction"] / ratio, drives["static_friction"] / ratio
    stribeck, viscous = drives["stribeck_speed"] * ratio, drives["viscous_friction"] / ratio**2
    root.append(Comment(" motor units: peak torque [N m], gains kp ki kd, LuGre friction "))
    actuators = SubElement(root, "actuator")
    for i in range(n):
        bristles = _BRISTLE * peak[i], _BRISTLE_DAMPING * peak[i]
        drive = {
            "name": f"axis_{i + 1}",
            "class": "motor",
            "joint": f"motor_{i + 1}",
            "gear": number(ratio[i]),
            "saturation": f"{number(peak[i])} 0 0",
            "damping": number(viscous[i]),
            "controller": row([kp[i], ki[i], kd[i], 0, 0, 0]),
            "lugre": row([*bristles, coulomb[i], static[i], stribeck[i]]),
        }
        SubElement(actuators, "dcmotor", drive)


def _add_sensors(root: Element, n: int) -> None:
    sensors, axes = SubElement(root, "sensor"), range(1, n + 1)
    for i in axes:
        SubElement(sensors, "jointpos", name=f"axis_{i}_pos", joint=f"motor_{i}")
    for i in axes:
        SubElement(sensors, "actuatorfrc", name=f"axis_{i}_torque", actuator=f"axis_{i}")
    SubElement(sensors, "accelerometer", name="imu_acc", site="imu")
    SubElement(sensors, "gyro", name="imu_gyro", site="imu")
    for kind, name in (("framepos", "tool0_pos"), ("framequat", "tool0_quat")):
        SubElement(sensors, kind, name=name, objtype="site", objname="tool0")
