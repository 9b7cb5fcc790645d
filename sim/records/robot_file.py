"""`robot.xml`: the robot of a run in one MJCF file, with which its replay is drawn."""

from pathlib import Path

import mujoco

from .atomic import write_whole
from .errors import InputError


def write_robot(file: Path, spec: mujoco.MjSpec) -> None:
    """Write a robot's MJCF, includes inserted. Meshes stay where they are, by absolute path."""
    own = spec.copy()
    folder = Path(spec.modelfiledir).resolve()
    if any(mesh.file for mesh in own.meshes):
        own.meshdir = str(folder / spec.meshdir)
    if any(texture.file for texture in own.textures):
        own.texturedir = str(folder / spec.texturedir)
    own.compile()
    write_whole(file, own.to_xml())


def read_robot(file: Path) -> mujoco.MjModel:
    """Compiled robot. Raises InputError for a file that MuJoCo does not accept."""
    try:
        return mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        raise InputError(f"{file} is not a usable MJCF model: {error}") from error
