"""A correction in a file: one that was exported, one of a run of `learn`, or one's own."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from armside.ilc.workbench.csv_signal import CsvSignal

from ..records.files import InputError
from ..records.tables import read_table

PREFIXES = ("correction", "u")
"""Names of the columns, before their numbers from 1."""


def read_correction(file: Path) -> CsvSignal:
    """Columns correction_1, correction_2, ... (or u_1, ...) of a CSV, MAT, HDF5 or Parquet file,
    and time [s] if it has that.

    Raises InputError for other columns, values that are missing, or a time that does not increase.
    """
    table = read_table(file)
    names = table.column_names
    prefix = next((p for p in PREFIXES if f"{p}_1" in names), None)
    if prefix is None:
        found = ", ".join(names[:4])
        raise InputError(f"{file} holds no correction: no column correction_1, but {found}")
    n = next(i for i in range(1, len(names) + 2) if f"{prefix}_{i}" not in names) - 1
    values = np.column_stack([_numbers(table, f"{prefix}_{i + 1}") for i in range(n)])
    time = _numbers(table, "time") if "time" in names else None
    if not np.isfinite(values).all():
        raise InputError(f"{file}: values of the correction are missing or not finite")
    if time is not None and not (len(time) > 1 and (np.diff(time) > 0.0).all()):
        raise InputError(f"{file}: time must increase")
    return CsvSignal(file, time, values)


def _numbers(table: pa.Table, name: str) -> np.ndarray:
    return table[name].cast(pa.float64()).to_numpy(zero_copy_only=False)
