"""References of the workbench: step, ramp, or a CSV file."""

from pathlib import Path

import numpy as np

from armside.arrays import Array

from ..models.two_mass import step_reference
from .csv_signal import read_signal

SHAPES = ("step", "ramp")
LEAST = 40
"""Samples of a record with a move in it."""


def named_reference(name: str, n_samples: int, n_columns: int, sample_time: float) -> Array:
    """r, shape (N, n): a shape, the same in all columns, or the columns of a CSV file.

    step: a unit step through two moving averages, as in thesis Fig 8.4, from an eighth of the
    record on. ramp: from 0 to 1 over the middle half. A file with a column time is brought to the
    sample time, over its own duration.

    Raises ValueError for a name or file that cannot be used.
    """
    if name not in SHAPES:
        return file_reference(Path(name), n_columns, sample_time)
    if n_samples < LEAST:
        raise ValueError(f"samples must be >= {LEAST}, got {n_samples}")
    if name == "step":
        start = (n_samples // 8) * sample_time
        column = step_reference(n_samples, sample_time, start, n_samples // 20)
    else:
        column = np.clip(2.0 * np.arange(n_samples) / n_samples - 0.5, 0.0, 1.0)[:, None]
    return np.repeat(column, n_columns, axis=1)


def file_reference(file: Path, n_columns: int | None, sample_time: float) -> Array:
    """r of a CSV file at a sample time [s]. Raises ValueError."""
    if not file.exists():
        raise ValueError(f"no reference {str(file)!r}: give {', '.join(SHAPES)} or a CSV file")
    signal = read_signal(file)
    n_samples = len(signal.values)
    if signal.time is not None:
        n_samples = round(float(signal.time[-1] - signal.time[0]) / sample_time) + 1
    if n_columns is not None and signal.values.shape[1] != n_columns:
        found = signal.values.shape[1]
        raise ValueError(f"{file} must have {n_columns} columns of reference, got {found}")
    if n_samples > 10_000_000:
        raise ValueError(f"{file} has {n_samples} samples at {sample_time:g} s: at most 1e7")
    return signal.at(n_samples, sample_time)
