"""`armside convert`: a run's signals for other tools."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from armside.sim.records import read_run
from armside.sim.records.files import check_file_to_write
from armside.sim.records.summary import summary

from ..shell.console import Report, keep
from ..shell.errors import InputError, checking_input
from ..shell.options import Common, FileToWrite, options


@options
@dataclass(frozen=True, kw_only=True)
class ConvertCfg:
    """Kind of file, and its place."""

    to: Literal["csv", "mat", "hdf5", "mcap"] = "csv"
    """Kind of file; hdf5 and mcap need the extra [convert]."""
    file: FileToWrite = None
    """File to write [default: signals.<kind> in the run's folder]."""


def convert(run: Path, *, cfg: ConvertCfg = ConvertCfg(), common: Common = Common()) -> None:
    """Write the signals of a run as CSV, MATLAB, HDF5 or MCAP.

    run: folder of the run. Columns and units are those of its signals.parquet; `armside measure`
    reads CSV, MATLAB and HDF5 back.
    """
    from armside.sim.records.tables import read_table, write_table

    report = Report(common)
    stored = read_run(run)
    file = cfg.file or run / f"signals.{cfg.to}"
    check_file_to_write(file)
    if file.suffix.lower() not in SUFFIXES[cfg.to]:
        raise InputError(f"{cfg.to} files end with {' or '.join(SUFFIXES[cfg.to])}: {file.name}")
    source = stored.file("signals.parquet")
    with checking_input():
        table = read_table(source)
    write_table(file, table)
    outcome = summary("convert", cfg, common, run=run, file=file, rows=table.num_rows)
    keep(outcome, common)
    report.line(f"{table.num_rows} rows of {table.num_columns} columns in {file}")
    report.summary(outcome)


SUFFIXES = {"csv": [".csv"], "mat": [".mat"], "hdf5": [".hdf5", ".h5"], "mcap": [".mcap"]}
