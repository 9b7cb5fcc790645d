"""Recordings of arms in motion, whose form is found out by looking at the folder."""

from pathlib import Path

from .motion import MotionRecording


def read_motion(folder: Path) -> MotionRecording:
    """Recording of a folder: tables, a run of armside, or a published set; see docs/real.md.

    Raises:
        ValueError: the folder is of no known form, or damaged; the message names file and place.
        OSError: a file cannot be read.
    """
    from . import aubo_i5, motion_tables, run_motion

    if not folder.is_dir():
        raise ValueError(f"{folder} is no folder of a recording")
    for form in (aubo_i5, run_motion, motion_tables):
        if form.recognised(folder):
            return form.read(folder)
    forms = "encoders.csv, ContinuousEvaluation.mat, or a run's signals.parquet"
    raise ValueError(f"{folder} is no recording of a known form: it needs {forms}")
