"""Files of a robot whose MJCF is built: the MJCF, and a robot file that names it."""

from math import gcd, pi
from typing import Any

from armside.kinematics.robot_file import link_tables, robot_tables

from ..cell import Cell

_PI = tuple(
    (n * pi / d, {1: "", -1: "-"}.get(n, f"{n}*") + ("pi" if d == 1 else f"pi/{d}"))
    for d in (1, 2, 3, 4, 6)
    for n in range(-4 * d, 4 * d + 1)
    if n and gcd(n, d) == 1
)
_ROUNDING = 1e-14


def number(value: float) -> float | str:
    """A number as a person writes it: a fraction of pi as text, such as "-pi/2", or a whole one."""
    value = float(value)
    for exact, text in _PI:
        if abs(value - exact) < _ROUNDING:
            return text
    return int(value) if value == int(value) and abs(value) < 1e9 else value


def built_files(cell: Cell, stem: str) -> dict[str, str]:
    """Text of each file by its name: STEM.xml, STEM.toml and programs of the IMU experiment."""
    import tomlkit

    found = {f"{stem}.xml": cell.xml.read_text(encoding="utf-8")}
    found[f"{stem}.toml"] = tomlkit.dumps(_tables(cell, f"{stem}.xml"))
    for files in cell.programs.values():
        found |= {f"programs/{file.name}": file.read_text(encoding="utf-8") for file in files}
    return found


def _tables(cell: Cell, model: str) -> dict[str, Any]:
    known = robot_tables(cell.robot, cell.limits, number)
    tables = {name: known.pop(name) for name in ("link", "limits")}
    known |= {"model": model, "orientation": "free" if cell.free_rotation else "held"}
    if cell.home is not None:
        known["home"] = [*map(number, cell.home)]
    known |= tables
    if imu := cell.with_imu.links[len(cell.robot.links) :]:
        known["imu"] = [
            {name: value for name, value in table.items() if name != "joint"}
            for table in link_tables(imu, number)
        ]
    known["pose"] = {
        name: {"position": list(pose.position), "quaternion": list(pose.quaternion)}
        for name, pose in cell.poses.items()
    }
    if cell.programs:
        known["program"] = {
            motion: [f"programs/{file.name}" for file in files]
            for motion, files in cell.programs.items()
        }
    if (own := cell.learning) is not None:
        design = {"gamma": number(own.gamma), "delta": own.delta, "cutoff": number(own.cutoff)}
        known["learning"] = design
    return known
