"""Files of a robot whose MJCF is built: the MJCF, and a robot file that names it."""

from dataclasses import replace

from armside.kinematics import Link

from ..cell import Cell
from .toml_text import kinematics_of, limits_of, links_of, number, row, text


def built_files(cell: Cell, stem: str) -> dict[str, str]:
    """Text of each file by its name: STEM.xml, STEM.toml and programs of the IMU experiment."""
    programs = {
        motion: [f"programs/{file.name}" for file in files]
        for motion, files in cell.programs.items()
    }
    found = {f"{stem}.xml": cell.xml.read_text(encoding="utf-8")}
    found[f"{stem}.toml"] = _robot_file(cell, f"{stem}.xml", programs)
    for files in cell.programs.values():
        found |= {f"programs/{file.name}": file.read_text(encoding="utf-8") for file in files}
    return found


def _robot_file(cell: Cell, model: str, programs: dict[str, list[str]]) -> str:
    lines = [*kinematics_of(cell.robot), f"model = {text(model)}"]
    lines.append(f'orientation = "{"free" if cell.free_rotation else "held"}"')
    if cell.home is not None:
        lines.append(f"home = {row(cell.home)}")
    lines += [*links_of("link", cell.robot.links), *limits_of(cell.limits)]
    lines += links_of("imu", _imu_links(cell))
    for name, pose in cell.poses.items():
        lines += ["", f"[pose.{text(name)}]", f"position = {row(pose.position)}"]
        lines.append(f"quaternion = {row(pose.quaternion)}")
    if programs:
        lines += ["", "[program]"]
        lines += [f"{text(m)} = [{', '.join(map(text, files))}]" for m, files in programs.items()]
    if (own := cell.learning) is not None:
        lines += ["", "[learning]", f"gamma = {number(own.gamma)}"]
        lines += [f"delta = {own.delta}", f"cutoff = {number(own.cutoff)}"]
    return "\n".join([*lines, ""])


def _imu_links(cell: Cell) -> list[Link]:
    """Constant links from the tool to the IMU; joint types are not written in [[imu]]."""
    own = cell.with_imu.links[len(cell.robot.links) :]
    return [replace(link, joint=Link().joint) for link in own]
