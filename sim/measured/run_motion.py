"""Recording of a run of armside: what its sensors measured, never the ground truth."""

from pathlib import Path

import numpy as np
import pyarrow.compute as pc

from armside.arrays import Array

from ..records.stored_run import read_run
from ..records.tables import read_table
from .motion import MotionRecording, Stream
from .motion_tables import COLUMNS

FIRST = 0
"""Iteration that is read: later ones are corrected by what was learned."""


def recognised(folder: Path) -> bool:
    """True for a folder with the signals of a run."""
    return (folder / "signals.parquet").is_file() and (folder / "summary.json").is_file()


def read(folder: Path) -> MotionRecording:
    """Encoders, IMU and laser tracker of the first run. Raises ValueError for a damaged folder."""
    run = next((run for run in read_run(folder).signals.runs if run.k == FIRST), None)
    if run is None:
        raise ValueError(f"{folder} has no run k = {FIRST}")
    tracker: Stream | None = None
    if run.tracker is not None and run.tracker.valid.any():
        seen = run.tracker.valid
        tracker = Stream(run.tracker.time[seen], run.tracker.position[seen])
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
    table = read_table(file)
    table = table.filter(pc.field("k") == FIRST)

    def numbers(name: str) -> Array:
        return np.array(table[name].to_numpy(), dtype=np.float64)

    values = np.column_stack([numbers(f"imu_{name}") for name in COLUMNS["imu"]])
    return Stream(numbers("imu_time"), values)
