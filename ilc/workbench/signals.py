"""Signals in CSV files, a column a motor, with a first column `time` [s] or without it; references.

Rule of alignment: a file without `time` must have as many rows as the reference. One with `time`
is interpolated linearly at the times of the reference, which it must cover to half a sample; rows
at these very times are taken as they are. Lines that begin with # are comments.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.arrays import Array, check_rising

from ..models.two_mass import step_reference
from ..records import records

LARGEST_FILE = 200_000_000
"""[bytes]."""


@dataclass(frozen=True, eq=False)
class CsvSignal:
    """Samples of a file."""

    file: Path
    time: Array | None
    """(N,) [s], increasing."""
    values: Array
    """(N, n), finite."""

    @property
    def sample_time(self) -> float | None:
        """Median step of the time column [s]; None without one."""
        if self.time is None or len(self.time) < 2:
            return None
        return float(np.median(np.diff(self.time)))

    def at(self, n_samples: int, sample_time: float) -> Array:
        """Samples at 0, T, 2 T, ... after the first, shape (n_samples, n). ValueError if short."""
        if self.time is None:
            if len(self.values) != n_samples:
                rule = f"{n_samples} rows, or a column time"
                raise ValueError(f"{self.file} needs {rule}, got {len(self.values)} rows")
            return self.values
        wanted, given = np.arange(n_samples) * sample_time, self.time - self.time[0]
        if given[-1] < wanted[-1] - 0.5 * sample_time:
            covered = f"{given[-1]:g} s, the reference lasts {wanted[-1]:g} s"
            raise ValueError(f"{self.file} is too short: it covers {covered}")
        if len(given) == n_samples and np.allclose(given, wanted, rtol=0, atol=1e-6 * sample_time):
            return self.values
        return np.stack([np.interp(wanted, given, column) for column in self.values.T], axis=1)


def read_signal(file: Path) -> CsvSignal:
    """Read a file with or without a header. Raises ValueError with file, row and reason."""
    try:
        if not file.is_file():
            raise ValueError(f"{file} does not exist, or is no file")
        if file.stat().st_size > LARGEST_FILE:
            raise ValueError(f"{file} is larger than {LARGEST_FILE / 1e6:.0f} MB")
        with file.open(encoding="utf-8-sig", newline="") as stream:
            rows = [(reader.line_num, row) for reader in [csv.reader(stream)] for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{file} is no readable CSV file: {error}") from error
    filled = [(line, row) for line, row in rows if any(cell.strip() for cell in row)]
    rows = [(line, row) for line, row in filled if not row[0].lstrip().startswith("#")]
    head = [cell.strip().lower() for cell in rows[0][1]] if rows else []
    named = bool(rows) and not _is_number(head[0])
    rows = rows[1:] if named else rows
    if not rows:
        raise ValueError(f"{file} holds no samples")
    table = np.array([_numbers(file, line, row, len(rows[0][1])) for line, row in rows])
    if not (named and head[0].split()[0] in ("time", "t", "time[s]")):
        return CsvSignal(file, None, table)
    time, values = table[:, 0], table[:, 1:]
    if values.shape[1] == 0:
        raise ValueError(f"{file} has a column time and no other")
    check_rising(file, time)
    return CsvSignal(file, time, values)


@records("values")
def write_signal(file: Path, values: Array, sample_time: float, name: str) -> None:
    """Write time [s] and columns name_1, name_2, ... with every digit."""
    lines = [",".join(["time", *(f"{name}_{i + 1}" for i in range(values.shape[1]))])]
    for i, row in enumerate(values.tolist()):
        lines.append(",".join(map(repr, [i * sample_time, *row])))
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _numbers(file: Path, line: int, row: list[str], n: int) -> list[float]:
    if len(row) != n:
        raise ValueError(f"{file}, line {line}: {n} columns are needed, got {len(row)}")
    bad = [cell for cell in row if not (_is_number(cell) and np.isfinite(float(cell)))]
    if bad:
        raise ValueError(f"{file}, line {line}: a finite number is needed, got {bad[0][:40]!r}")
    return [float(cell) for cell in row]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


SHAPES = ("step", "ramp")
LEAST = 40
"""Samples of a record with a move in it."""


def named_reference(name: str, n_samples: int, n_columns: int, sample_time: float) -> Array:
    """r, shape (N, n): a shape, the same in all columns, or the columns of a CSV file.

    step: a unit step through two moving averages, as in thesis Fig 8.4, from an eighth of the
    record on. ramp: from 0 to 1 over the middle half. A file with a column time is brought to the
    sample time, over its own duration.
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
