"""Hashes of the content of files that the options of a job name."""

import hashlib
from pathlib import Path

import mujoco

from armside.kinematics.robot_file import read_toml
from armside.sim.records.files import check_file
from armside.sim.robot_file.find import read_cell

from ..shell.errors import InputError


def digest_of_file(file: Path) -> str:
    """Raises ValueError or OSError for a file that cannot be read."""
    return hashlib.sha256(check_file(file).read_bytes()).hexdigest()


def model_content(file: Path) -> str:
    """Hash of an MJCF and of the files that it includes. Raises InputError for one that is none."""
    check_file(file)
    try:
        parts = mujoco.mju_getXMLDependencies(str(file))
    except mujoco.FatalError as error:
        raise InputError(f"{file} is not a usable MJCF model: {error}") from error
    return _together([digest_of_file(file), *sorted(digest_of_file(Path(part)) for part in parts)])


def robot_content(file: str | Path) -> str:
    """Hash of a robot file, and of the MJCF and URDF that it names.

    Raises ValueError or OSError for a file that is none, or names none.
    """
    file = Path(file)
    xml, urdf = read_cell(file).xml, read_toml(file, lambda data: data.get("urdf"))
    parts = [digest_of_file(file), model_content(xml)]
    if urdf is not None:
        parts.append(digest_of_file(file.parent / str(urdf).partition("#")[0]))
    return _together(parts)


def _together(digests: list[str]) -> str:
    return hashlib.sha256("".join(digests).encode()).hexdigest()
