"""A robot file with every table it may have: known numbers, and estimates as comments."""

import numpy as np

from armside import kinematics
from armside.kinematics import Joint, Limits
from armside.kinematics.rotation import to_quaternion

from ..hardware.build import Built, build
from ..hardware.description import Hardware, LinkBody
from ..hardware.keys import DRIVES, EFFECTS, GEARS
from .source import Source
from .toml_text import kinematics_of, limits_of, links_of, number, row

_BEND = 0.5
"""[rad], of each axis away from the middle of its range, at which a first pose is placed: an arm
that is stretched has a singularity there. ESTIMATE."""
_DECIMALS = 12


def commented(source: Source) -> str:
    """Text of a robot file.

    Raises ValueError for a robot whose hardware cannot be built.
    """
    robot, limits = source.arm
    home = start(limits, tuple(link.joint for link in robot.links if link.moves))
    built = build(robot, limits, source.hardware, home=home)
    lines = [
        f"# Robot file, made from: {source.said}. Numbers behind # are defaults: take the # away",
        "# to state another. `armside robot check FILE` lists each that is taken, with its rule.",
        *kinematics_of(robot),
        f"home = {row(home)} # motor angles near which poses are reached [rad or m]",
        '# orientation = "held" # or "free": contours set the tool\'s position alone',
        "",
        "# D-H table, from the base [m], [rad]",
        *links_of("link", robot.links)[1:],
        *limits_of(limits),
        *_masses(source.hardware, built, robot.n_joints),
        *_drives(built),
        *_effects(),
        *_pose(robot, home),
        "",
        "# [learning] # design of learning from motor angles",
        "# gamma = 0.9",
        "# delta = 3 # [samples of 4 ms]",
        "# cutoff = 10 # [Hz]",
        "",
    ]
    return "\n".join(lines)


def start(limits: Limits, kinds: tuple[Joint, ...]) -> tuple[float, ...]:
    """Motor angles of a bent arm within the limits, (n,)."""
    low, high = np.array(limits.lower), np.array(limits.upper)
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    middle = np.where((low < 0) & (high > 0), 0.0, middle)
    signs = np.where(np.arange(len(low)) % 2 == 0, 1.0, -1.0)
    bend = np.minimum(_BEND, 0.5 * half) * signs
    bend = np.where([kind is Joint.PRISMATIC for kind in kinds], 0.0, bend)
    return tuple(np.clip(middle + bend, low, high).round(4).tolist())


def _masses(given: Hardware, built: Built, n: int) -> list[str]:
    said = {taken.field: taken for taken in built.taken}
    lines = ["", "[hardware]"]
    if (whole := said.get("hardware: mass")) is not None:
        lines.append(f"# mass = {number(whole.values[0])} # [kg], tool excluded. {whole.rule}")
    else:
        lines.append("# mass = # [kg] of the whole robot, tool excluded")
    lines += ["# time_step = 0.0005 # [s]", ""]
    lines += ["# one for each moving link, in the axes of its D-H frame"]
    masses = iter(said["body: mass"].values if "body: mass" in said else ())
    for body in given.bodies or (LinkBody(),) * n:
        lines += ["", "[[body]]" if body != LinkBody() else "# [[body]]"]
        lines.append(
            f"mass = {number(body.mass)} # [kg]"
            if body.mass is not None
            else f"# mass = {number(next(masses))} # [kg]"
        )
        for name, unit in (("centre", "[m]"), ("inertia", "xx yy zz xy xz yz [kg m^2]")):
            value = getattr(body, name)
            if value is not None:
                lines.append(f"{name} = {row(round(v, _DECIMALS) for v in value)} # {unit}")
    lines += ["", "[tool] # in the axes of the tool frame"]
    for name, unit in (("mass", "[kg]"), ("centre", "[m]"), ("inertia", "[kg m^2]")):
        if (taken := said.get(f"tool: {name}")) is not None:
            value = number(taken.values[0]) if name == "mass" else row(taken.values)
            lines.append(f"# {name} = {value} # {unit}. {taken.rule}")
    return lines


def _drives(built: Built) -> list[str]:
    said, lines = {taken.field: taken for taken in built.taken}, list[str]()
    for where, keys in (("drives", DRIVES), ("gears", GEARS)):
        lines += ["", f"[{where}] # arm side of the gear"]
        for name, key in keys.items():
            unit = f" [{key.unit}]" if key.unit else ""
            taken = said.get(f"{where}: {name}")
            value = "" if taken is None else _list(taken.values, key.size)
            rule = f"; {key.default}" if key.default else ""
            lines.append(f"# {name} = {value} #{unit} {key.meaning}{rule}".replace("=  #", "= #"))
    return lines


def _list(values: tuple[float, ...], size: int) -> str:
    return number(values[0]) if size == 1 else row(values)


def _effects() -> list[str]:
    lines = ["", "# [effects] # absent where they are not given"]
    for name, key in EFFECTS.items():
        unit = f" [{key.unit}]" if key.unit else ""
        lines.append(f"# {name} = #{unit} {key.meaning}; default: {key.default}")
    return lines


def _pose(robot: kinematics.Robot, home: tuple[float, ...]) -> list[str]:
    T = kinematics.compile(robot).pose(np.array(home))
    q = to_quaternion(T[:3, :3]).round(9).tolist()
    return [
        "",
        "[pose.p1] # the tool at home",
        f"position = {row(T[:3, 3].round(6).tolist())} # [m]",
        f"quaternion = {row(q)} # w first, base to tool",
    ]
