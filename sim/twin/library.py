"""Twins and their corrections, kept in this process: equal cuts are learned once."""

from dataclasses import replace
from functools import lru_cache
from hashlib import sha256
from os import PathLike
from pathlib import Path

from ..laser.specification import Cut
from ..records.files import check_file
from .correction import Corrected
from .twin import FILES, Twin, TwinError

_TWINS, _CORRECTIONS = 8, 256
"""Kept at most; a correction of two seconds of motion takes 75 kB."""


def digest(folder: str | PathLike[str]) -> str:
    """Hash of the content of a twin, wherever it is. Raises TwinError for a folder without one."""
    hashed = sha256()
    try:
        for name in FILES:
            hashed.update(sha256(check_file(Path(folder) / name).read_bytes()).digest())
    except (ValueError, OSError):
        Twin.load(folder)  # says what is missing
        raise TwinError(f"{folder} cannot be read") from None
    return hashed.hexdigest()


def stored_twin(folder: str | PathLike[str]) -> Twin:
    """The twin of a folder, read once as long as it stays the same. Raises as `Twin.load`."""
    return _read(Path(folder).absolute(), digest(folder))


def learned(twin: Twin, cut: Cut) -> Corrected:
    """`Twin.correction` of a cut, learned once for all cuts that differ in the robot's state alone.

    Raises as `Twin.correction`.
    """
    by_design = {"individual": None, "temperature": None, "without": (), "imu": None}
    of_robot = {"friction_spread": 0.0, "friction_drift": 0.0}
    return _learned(twin, replace(cut, **by_design, **of_robot))


@lru_cache(_TWINS)
def _read(folder: Path, _content: str) -> Twin:
    return Twin.load(folder)


@lru_cache(_CORRECTIONS)
def _learned(twin: Twin, cut: Cut) -> Corrected:
    return twin.correction(cut)
