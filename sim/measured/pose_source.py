"""Measured poses of an arm from a file or folder, whose form is found out by looking at it."""

from dataclasses import dataclass
from pathlib import Path

from armside.kinematics.calibration import Measurements

from ..records.files import LARGEST_DATA, check_file
from .bags import BagTopics


@dataclass(frozen=True, eq=False)
class PoseSource:
    """Measured poses, and what was left out of them and why."""

    measurements: Measurements
    form: str
    """Name of the form that was recognised."""
    notes: tuple[str, ...] = ()
    """One line for each kind of row that was left out."""


def read_poses(data: Path, topics: BagTopics = BagTopics()) -> PoseSource:
    """Poses of a table, a bag, or a published set: see docs/real.md.

    Args:
        data: file or folder.
        topics: of a bag.

    Raises:
        ValueError: the data are of no known form, or damaged; the message names file and place.
        OSError: a file cannot be read.
    """
    from . import irb120_tracker, pose_table, ur10_tmac
    from .bags import bag, poses

    if not data.exists():
        raise ValueError(f"{data} does not exist")
    if bag.recognised(data):
        return poses.read(data, topics)
    if topics.named:
        raise ValueError(f"{data} is no bag: topics and joints are chosen in bags")
    if data.is_dir():
        if irb120_tracker.recognised(data):
            return irb120_tracker.read(data)
        tables = sorted(data.glob("measurements_*.csv"))
        if len(tables) == 1:
            return ur10_tmac.read(check_file(tables[0], LARGEST_DATA))
        names = ", ".join(table.name for table in tables)
        hint = f"; name one of {names}" if tables else ""
        raise ValueError(f"{data} is no folder of a known form{hint}")
    check_file(data, LARGEST_DATA)
    return ur10_tmac.read(data) if ur10_tmac.recognised(data) else pose_table.read(data)
