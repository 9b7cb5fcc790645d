"""Recordings of arms in motion, whose form is found out by looking at the folder or file."""

from pathlib import Path
from typing import Protocol

from .bags import BagTopics
from .motion import MotionRecording


class Form(Protocol):
    """Module that reads one form of folder."""

    def recognised(self, folder: Path, /) -> bool:
        """True for a folder of this form."""
        ...

    def read(self, folder: Path, /) -> MotionRecording:
        """Recording of the folder."""
        ...


def is_motion(source: Path) -> bool:
    """True for what looks like a recording of a known form."""
    from .bags import bag

    return bag.recognised(source) or (source.is_dir() and _form(source) is not None)


def _form(folder: Path) -> Form | None:
    from . import aubo_i5, motion_tables, run_motion

    forms: tuple[Form, ...] = (aubo_i5, run_motion, motion_tables)
    return next((form for form in forms if form.recognised(folder)), None)


def read_motion(source: Path, topics: BagTopics = BagTopics()) -> MotionRecording:
    """Recording: a folder of tables, a bag, a run of armside, a published set; see docs/real.md.

    Args:
        source: folder, or file of a bag.
        topics: of a bag.

    Raises:
        ValueError: of no known form, or damaged; the message names file and place.
        OSError: a file cannot be read.
    """
    from .bags import bag, motion

    if bag.recognised(source):
        return motion.read(source, topics)
    if topics.named:
        raise ValueError(f"{source} is no bag: topics and joints are chosen in bags")
    if not source.is_dir():
        raise ValueError(f"{source} is no folder of a recording, and no bag")
    if (form := _form(source)) is not None:
        try:
            return form.read(source)
        except ValueError as error:
            name = source.resolve().name
            raise error if name in str(error) else ValueError(f"{name}: {error}") from error
    forms = "encoders.csv, metadata.yaml of a ROS 2 bag, ContinuousEvaluation.mat, or a run's "
    forms += "signals.parquet"
    raise ValueError(f"{source} is no recording of a known form: it needs {forms}")
