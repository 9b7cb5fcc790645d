"""Recordings from a file or folder, whose form is found out by looking at it: see docs/real.md."""

from collections.abc import Callable
from pathlib import Path

import pyarrow.compute as pc

from armside.arrays import check_recorded_time

from ..records.files import LARGEST_DATA, check_file
from ..records.stored_run import read_run
from ..records.tables import float_columns, read_table
from .bags import BagTopics
from .bags.bag import motion_of_bag, poses_of_bag
from .bags.messages import is_bag
from .published import is_aubo, is_irb120, is_ur10, read_aubo, read_irb120, read_ur10
from .recorded_motion import MotionRecording, PoseRecording, Stream
from .tables import COLUMNS, instrument_table, read_motion_tables, read_pose_table

FIRST = 0
"""Iteration of a run that is read: later ones are corrected by what was learned."""
Reader = Callable[[Path], MotionRecording]


def is_motion(source: Path) -> bool:
    """True for what looks like a recording of a known form."""
    return is_bag(source) or (source.is_dir() and _reader(source) is not None)


def read_motion(source: Path, topics: BagTopics = BagTopics()) -> MotionRecording:
    """Recording in a folder of tables, a bag, a run of armside, or a published set.

    topics: of a bag. Raises ValueError, with file and place, for data of no known form, or damaged;
    OSError where a file cannot be read.
    """
    if is_bag(source):
        return motion_of_bag(source, topics)
    _refuse_topics(source, topics)
    if not source.is_dir():
        raise ValueError(f"{source} is no folder of a recording, and no bag")
    if (reader := _reader(source)) is not None:
        try:
            return reader(source)
        except ValueError as error:
            name = source.resolve().name
            raise error if name in str(error) else ValueError(f"{name}: {error}") from error
    forms = "encoders.csv, metadata.yaml of a ROS 2 bag, ContinuousEvaluation.mat"
    unknown = f"{source} is no recording of a known form: it needs {forms}"
    raise ValueError(f"{unknown}, or a run's signals.parquet")


def _reader(folder: Path) -> Reader | None:
    if is_aubo(folder):
        return read_aubo
    if (folder / "signals.parquet").is_file() and (folder / "summary.json").is_file():
        return read_run_motion
    return read_motion_tables if instrument_table(folder) else None


def read_run_motion(folder: Path) -> MotionRecording:
    """Encoders, IMU and laser tracker of a run's k = 0: its sensors, never the ground truth."""
    run = next((run for run in read_run(folder).signals.runs if run.k == FIRST), None)
    if run is None:
        raise ValueError(f"{folder} has no run k = {FIRST}")
    tracker, own = None, run.tracker
    if own is not None and own.valid.any():
        tracker = Stream(own.time[own.valid], own.position[own.valid])
    return MotionRecording(
        name=folder.name,
        encoders=Stream(run.recording.time, run.recording.motor_angle),
        imu=_imu(folder / "imu.parquet"),
        tracker=tracker,
        form="run of armside",
    )


def _imu(file: Path) -> Stream | None:
    if not file.is_file():
        return None
    table = read_table(file).filter(pc.field("k") == FIRST)
    values = float_columns(table, [f"imu_{name}" for name in COLUMNS["imu"]])
    time = float_columns(table, ["imu_time"])[:, 0]
    check_recorded_time(file.name, time)
    return Stream(time, values)


def read_poses(data: Path, topics: BagTopics = BagTopics()) -> PoseRecording:
    """Poses of a table, a bag (`topics` are its own), or a published set.

    Raises ValueError for data of no known form, or damaged, with file and place, and OSError for a
    file that cannot be read.
    """
    if not data.exists():
        raise ValueError(f"{data} does not exist")
    if is_bag(data):
        return poses_of_bag(data, topics)
    _refuse_topics(data, topics)
    if data.is_dir():
        if is_irb120(data):
            return read_irb120(data)
        tables = sorted(data.glob("measurements_*.csv"))
        if len(tables) == 1:
            return read_ur10(check_file(tables[0], LARGEST_DATA))
        names = ", ".join(table.name for table in tables)
        hint = f"; name one of {names}" if tables else ""
        raise ValueError(f"{data} is no folder of a known form{hint}")
    check_file(data, LARGEST_DATA)
    return read_ur10(data) if is_ur10(data) else read_pose_table(data)


def _refuse_topics(source: Path, topics: BagTopics) -> None:
    if topics.named:
        raise ValueError(f"{source} is no bag: topics and joints are chosen in bags")
