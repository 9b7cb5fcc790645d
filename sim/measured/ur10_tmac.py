"""UR10 with a Leica T-Mac at its flange, christianlandgraf/ipa-robot-accuracy.

Tables with semicolons and decimal commas: joint angles [rad], position [mm] and Euler angles [deg]
of the T-Mac in the frame of the tracker. Time stamps are rounded to six digits and not read.
"""

from pathlib import Path

import numpy as np

from armside.arrays import Array
from armside.kinematics.calibration import Measurements

from .pose_source import PoseSource

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
POSITION = ("measurement_x", "measurement_y", "measurement_z")
MM = 1e-3


def recognised(file: Path) -> bool:
    """True for a file whose first line is the header of these tables."""
    with file.open("rb") as content:
        first = content.readline(4096)
    return b";" in first and JOINTS[0].encode() in first


def read(file: Path) -> PoseSource:
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

    def columns(names: tuple[str, ...]) -> Array:
        places = [header.index(name) for name in names]
        return np.array(
            [[_number(file, i, row[k]) for k in places] for i, row in enumerate(rows, 1)]
        )

    points = MM * columns(POSITION)[:, None]
    return PoseSource(Measurements(phi=columns(JOINTS), points=points), "UR10 with T-Mac")


def _number(file: Path, row: int, text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise ValueError(f"{file.name}: row {row}: {text[:40]!r} is not a number") from None
