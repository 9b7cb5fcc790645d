"""Published recordings of real arms, in the files of their authors.

ABB IRB120 with three reflectors at its tool, icelinker/Robot-Calibration-LaserTracker: a folder of
text files, measured_joints.txt [deg], measured_SMR_1..3.txt and measured_base_1..3.txt [mm],
reflectors at the tool and at the base in the frame of the tracker. A pose in which a reflector of
the base is off its place was measured by a tracker that had moved, or not at all.

UR10 with a Leica T-Mac at its flange, christianlandgraf/ipa-robot-accuracy: tables with semicolons
and decimal commas, joint angles [rad], position [mm] and Euler angles [deg] of the T-Mac in the
frame of the tracker. Time stamps are rounded to six digits and not read.

AUBO i5 in continuous motion with an IMU and cameras, fergujm2/ContinuousRobotCalibration: a folder
of one day has ContinuousEvaluation.mat (tRobot [s], q [rad], tImu [s], z: specific force [m/s^2]
and angular rate [rad/s]) and ContinuousEvaluationTracker.mat (t [s], p [m], on one day [mm]), or
the same with "Evalution". The clocks do not agree.
"""

from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.kinematics.calibration import Measurements

from ..records.files import LARGEST_DATA, check_file
from .bags.bag import UR
from .recorded_motion import MotionRecording, PoseRecording, Stream, repaired

MM = 1e-3
DRIFT = 0.3e-3
"""[m] Largest distance of a reflector at the base from its median place."""
REFLECTORS = (1, 2, 3)


def is_irb120(folder: Path) -> bool:
    """True for a folder with the IRB120's file of joint angles."""
    return (folder / "measured_joints.txt").is_file()


def read_irb120(folder: Path) -> PoseRecording:
    """Poses whose base reflectors are in place. Raises ValueError for a damaged file."""
    phi = np.radians(_text_table(folder / "measured_joints.txt", 6))
    tool = MM * _points(folder, "SMR", len(phi))
    base = MM * _points(folder, "base", len(phi))
    away = np.linalg.norm(base - np.median(base, axis=0), axis=2).max(axis=1)
    still = away <= DRIFT
    measurements = Measurements(phi=phi, points=tool)[np.flatnonzero(still)]
    rows = ", ".join(str(row + 1) for row in np.flatnonzero(~still))
    text = f"{(~still).sum()} rows left out: base reflectors off by more than 0.3 mm: {rows}"
    return PoseRecording(measurements, "IRB120 with tracker", () if still.all() else (text,))


def _points(folder: Path, name: str, n: int) -> Array:
    tables = [_text_table(folder / f"measured_{name}_{i}.txt", 3) for i in REFLECTORS]
    for i, table in zip(REFLECTORS, tables, strict=True):
        if len(table) != n:
            text = f"measured_{name}_{i}.txt has {len(table)} rows"
            raise ValueError(f"{text}, measured_joints.txt has {n}")
    return np.stack(tables, axis=1)


def _text_table(file: Path, columns: int) -> Array:
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


JOINTS = tuple(f"{name}_joint" for name in UR)
POSITION = ("measurement_x", "measurement_y", "measurement_z")


def is_ur10(file: Path) -> bool:
    """True for a file whose first line is the header of these tables."""
    with file.open("rb") as content:
        first = content.readline(4096)
    return b";" in first and JOINTS[0].encode() in first


def read_ur10(file: Path) -> PoseRecording:
    """Poses of one series. Raises ValueError for a damaged table."""
    lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
    header = lines[0].split(";")
    if absent := [name for name in (*JOINTS, *POSITION) if name not in header]:
        raise ValueError(f"{file.name}: columns are missing: {', '.join(absent)}")
    rows = [line.split(";") for line in lines[1:] if line.strip()]
    if not rows:
        raise ValueError(f"{file.name}: has no rows")
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            text = f"row {number} has {len(row)} columns, the header {len(header)}"
            raise ValueError(f"{file.name}: {text}")
    places = [header.index(name) for name in (*POSITION, *JOINTS)]
    found = np.array([[_number(file, i, row[k]) for k in places] for i, row in enumerate(rows, 1)])
    measurements = Measurements(phi=found[:, 3:].copy(), points=MM * found[:, None, :3])
    return PoseRecording(measurements, "UR10 with T-Mac")


def _number(file: Path, row: int, text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise ValueError(f"{file.name}: row {row}: {text[:40]!r} is not a number") from None


NAMES = ("ContinuousEvaluation", "ContinuousEvalution")
FARTHEST = 100.0
"""[m] Distance of cameras beyond which their unit is millimetres."""


def is_aubo(folder: Path) -> bool:
    """True for a folder with the file of robot and IMU."""
    return any((folder / f"{name}.mat").is_file() for name in NAMES)


def read_aubo(folder: Path) -> MotionRecording:
    """Recording of one day. Raises ValueError for a damaged file."""
    stem = next(name for name in NAMES if (folder / f"{name}.mat").is_file())
    robot = _content(folder / f"{stem}.mat", {"tRobot": 1, "q": 6, "tImu": 1, "z": 6})
    encoders, notes = repaired("encoders", robot["tRobot"].ravel(), robot["q"])
    # The first rows of a log are zero until the IMU has sent something.
    started = robot["z"][:, :3].any(axis=1)
    imu, of_imu = repaired("IMU", robot["tImu"].ravel()[started], robot["z"][started])
    notes += of_imu
    tracker: Stream | None = None
    files = (folder / f"{name}Tracker.mat" for name in NAMES)
    if (file := next((file for file in files if file.is_file()), None)) is None:
        others = sorted(each.name for each in folder.glob("*.mat") if each.stem != stem)
        beside = f", and {', '.join(others)} is not read" if others else ""
        notes += (f"cameras: there is no {stem}Tracker.mat{beside}",)
    else:
        t, p = _content(file, {"t": 1, "p": 3}).values()
        if np.nanmedian(np.abs(p)) > FARTHEST:
            p = MM * p
            notes += ("cameras: positions are in millimetres, taken as such",)
        tracker, of_cameras = repaired("cameras", t.ravel(), p)
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
