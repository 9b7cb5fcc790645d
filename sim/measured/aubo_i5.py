"""AUBO i5 in continuous motion with an IMU and cameras, fergujm2/ContinuousRobotCalibration.

A folder of one day has ContinuousEvaluation.mat (tRobot [s], q [rad], tImu [s], z: specific force
[m/s^2] and angular rate [rad/s]) and ContinuousEvaluationTracker.mat (t [s], p [m], on one day
[mm]), or the same with "Evalution". The clocks do not agree.
"""

from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..records.files import LARGEST_DATA, check_file
from .motion import MotionRecording, Stream
from .repair import repaired

NAMES = ("ContinuousEvaluation", "ContinuousEvalution")
FARTHEST = 100.0
"""[m] Distance of cameras beyond which their unit is millimetres."""


def recognised(folder: Path) -> bool:
    """True for a folder with the file of robot and IMU."""
    return any((folder / f"{name}.mat").is_file() for name in NAMES)


def read(folder: Path) -> MotionRecording:
    """Recording of one day. Raises ValueError for a damaged file."""
    stem = next(name for name in NAMES if (folder / f"{name}.mat").is_file())
    robot = _content(folder / f"{stem}.mat", {"tRobot": 1, "q": 6, "tImu": 1, "z": 6})
    encoders, notes = repaired("encoders", robot["tRobot"].ravel(), robot["q"])
    # The first rows of a log are zero until the IMU has sent something.
    started = robot["z"][:, :3].any(axis=1)
    imu, of_imu = repaired("IMU", robot["tImu"].ravel()[started], robot["z"][started])
    notes += of_imu
    tracker: Stream | None = None
    if (file := folder / f"{stem}Tracker.mat").is_file():
        cameras = _content(file, {"t": 1, "p": 3})
        p = cameras["p"]
        if np.nanmedian(np.abs(p)) > FARTHEST:
            p = 1e-3 * p
            notes += ("cameras: positions are in millimetres, taken as such",)
        tracker, of_cameras = repaired("cameras", cameras["t"].ravel(), p)
        notes += of_cameras
    return MotionRecording(
        name=folder.name,
        encoders=encoders,
        imu=imu,
        tracker=tracker,
        form="AUBO i5 with IMU and cameras",
        notes=notes,
    )


def _content(file: Path, columns: dict[str, int]) -> dict[str, Array]:
    from scipy.io import loadmat

    try:
        content: dict[str, Any] = loadmat(check_file(file, LARGEST_DATA))
    except (ValueError, NotImplementedError, TypeError) as error:
        raise ValueError(f"{file.name}: {' '.join(str(error).split())}") from error
    for name, width in columns.items():
        value = content.get(name)
        if value is None or value.ndim != 2 or value.shape[1] != width or value.dtype.kind != "f":
            given = "nothing" if value is None else f"shape {value.shape}"
            raise ValueError(f"{file.name}: {name} must be numbers of {width} columns, got {given}")
    return {name: content[name] for name in columns}
