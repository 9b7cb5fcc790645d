"""ABB IRB120 with three reflectors at its tool, icelinker/Robot-Calibration-LaserTracker.

A folder of text files: measured_joints.txt [deg], measured_SMR_1..3.txt and measured_base_1..3.txt
[mm], reflectors at the tool and at the base in the frame of the tracker. A pose in which a
reflector of the base is off its place was measured by a tracker that had moved, or not at all.
"""

from pathlib import Path

import numpy as np

from armside.arrays import Array
from armside.kinematics.calibration import Measurements

from ..records.files import LARGEST_DATA, check_file
from .pose_source import PoseSource

MM = 1e-3
DRIFT = 0.3e-3
"""[m] Largest distance of a reflector at the base from its median place."""
REFLECTORS = (1, 2, 3)


def recognised(folder: Path) -> bool:
    """True for a folder with the file of joint angles."""
    return (folder / "measured_joints.txt").is_file()


def read(folder: Path) -> PoseSource:
    """Poses whose base reflectors are in place. Raises ValueError for a damaged file."""
    phi = np.radians(_table(folder / "measured_joints.txt", 6))
    tool = MM * _points(folder, "SMR", len(phi))
    base = MM * _points(folder, "base", len(phi))
    away = np.linalg.norm(base - np.median(base, axis=0), axis=2).max(axis=1)
    still = away <= DRIFT
    measurements = Measurements(phi=phi, points=tool)[np.flatnonzero(still)]
    rows = ", ".join(str(row + 1) for row in np.flatnonzero(~still))
    text = f"{(~still).sum()} rows left out: base reflectors off by more than 0.3 mm: {rows}"
    return PoseSource(measurements, "IRB120 with tracker", () if still.all() else (text,))


def _points(folder: Path, name: str, n: int) -> Array:
    tables = [_table(folder / f"measured_{name}_{i}.txt", 3) for i in REFLECTORS]
    for i, table in zip(REFLECTORS, tables, strict=True):
        if len(table) != n:
            text = f"measured_{name}_{i}.txt has {len(table)} rows"
            raise ValueError(f"{text}, measured_joints.txt has {n}")
    return np.stack(tables, axis=1)


def _table(file: Path, columns: int) -> Array:
    if not file.is_file():
        raise ValueError(f"{file.name} is missing in {file.parent}")
    try:
        values = np.loadtxt(check_file(file, LARGEST_DATA), ndmin=2)
    except ValueError as error:
        raise ValueError(f"{file.name}: {error}") from error
    if values.shape[1:] != (columns,) or not len(values):
        raise ValueError(f"{file.name} must have {columns} columns, got shape {values.shape}")
    if not np.isfinite(values).all():
        row = int(np.argwhere(~np.isfinite(values))[0][0]) + 1
        raise ValueError(f"{file.name}: row {row} has a number that is not finite")
    return values
