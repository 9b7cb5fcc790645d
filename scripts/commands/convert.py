"""`armside convert`: a run's signals, or a recording of a real arm, for other tools."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from armside.sim.records import read_run
from armside.sim.records.files import check_file_to_write, check_name
from armside.sim.records.run_folder import check_destination, check_writable
from armside.sim.records.summary import summary

from ..shell.bag_options import BagCfg
from ..shell.console import Report, keep
from ..shell.errors import InputError, checking_input
from ..shell.options import Common, FileToRead, options

Kind = Literal["csv", "parquet", "mat", "hdf5", "mcap"]
SUFFIXES: dict[str, list[str]] = {
    "csv": [".csv"],
    "parquet": [".parquet"],
    "mat": [".mat"],
    "hdf5": [".hdf5", ".h5"],
    "mcap": [".mcap"],
}


@options
@dataclass(frozen=True, kw_only=True)
class ConvertCfg(BagCfg):
    """Kind of file, and its place."""

    to: Kind = "csv"
    """Kind of file; hdf5 and mcap need the extra [convert], mcap of a recording [bags]."""
    file: Path | None = None
    """File to write, or folder for a recording [default: signals.KIND in the run's folder;
    NAME-KIND beside the recording, NAME-signals.KIND beside a log]."""
    columns: FileToRead = None
    """File (TOML) that says which columns of a controller's log are which (docs/formats.md)."""


def convert(source: Path, /, *, cfg: ConvertCfg = ConvertCfg(), common: Common = Common()) -> None:
    """Write a run, a recording of a real arm, or a controller's log as files of another kind.

    source: folder of a run; a recording (docs/real.md): a ROS bag, a folder of tables, a published
    set; or a log of ABB's or KUKA's controllers, or another's with --columns. Columns and units of
    a run are those of its signals.parquet; `armside measure` reads CSV, MATLAB and HDF5 back.
    """
    from armside.sim.recordings import is_motion
    from armside.sim.recordings.logs.read import SUFFIXES as LOGS

    report = Report(common)
    if source.is_file() and source.suffix.lower() in LOGS:
        return _log(source, cfg, common, report)
    if cfg.columns is not None:
        raise InputError(f"{source} is no log of a controller: --columns is of those")
    if not (source / "summary.json").exists() and is_motion(source):
        return _recording(source, cfg, common, report)
    _run(source, cfg, common, report)


def _run(run: Path, cfg: ConvertCfg, common: Common, report: Report) -> None:
    from armside.sim.records.tables import read_table, write_table

    if cfg.topics().named:
        raise InputError("topics and joints are chosen in bags, not in runs")
    stored = read_run(run)
    file = cfg.file or run / f"signals.{cfg.to}"
    _check_target(file, cfg.to)
    source = stored.file("signals.parquet")
    with checking_input():
        table = read_table(source)
    write_table(file, table)
    outcome = summary("convert", cfg, common, source=run, file=file, rows=table.num_rows)
    _tell(outcome, (), f"{table.num_rows} rows of {table.num_columns} columns in {file}", report)


def _recording(source: Path, cfg: ConvertCfg, common: Common, report: Report) -> None:
    """A recording in motion: a folder of tables, or a bag."""
    from armside.sim.recordings import read_motion
    from armside.sim.recordings.bags.write import write_bag
    from armside.sim.recordings.tables import write_motion_tables
    from armside.sim.records.atomic import staged

    folder = cfg.file or source.absolute().parent / f"{source.stem}-{cfg.to}"
    check_name(folder)
    check_destination(folder)
    check_writable(folder)
    with checking_input():
        recording = read_motion(source, cfg.topics())
    folder.parent.mkdir(parents=True, exist_ok=True)
    with staged(folder.resolve(), folder=True) as partial:
        if cfg.to == "mcap":
            write_bag(partial / folder.name, recording)
            (partial / folder.name).rename(folder.resolve())
        else:
            write_motion_tables(partial, recording, cfg.to)
            partial.rename(folder.resolve())
    samples = {
        name: len(stream.time)
        for name in ("encoders", "imu", "tracker")
        if (stream := getattr(recording, name)) is not None
    }
    notes = list(recording.notes)
    found = {"source": source, "folder": folder, "samples": samples, "notes": notes}
    outcome = summary("convert", cfg, common, form=recording.form, **found)
    written = ", ".join(f"{n} of {name}" for name, n in samples.items())
    _tell(outcome, notes, f"{written} in {folder}", report)


def _log(file: Path, cfg: ConvertCfg, common: Common, report: Report) -> None:
    """A controller's log."""
    from armside.sim.recordings.logs import read_log
    from armside.sim.records.tables import write_table

    if cfg.topics().named:
        raise InputError("topics and joints are chosen in bags, not in logs")
    target = cfg.file or file.with_name(f"{file.stem}-signals.{cfg.to}")
    _check_target(target, cfg.to)
    with checking_input():
        log = read_log(file, cfg.columns)
    write_table(target, log.table)
    rows, notes = log.table.num_rows, list(log.notes)
    found = {"source": file, "file": target, "rows": rows, "notes": notes}
    outcome = summary("convert", cfg, common, form=log.form, **found)
    _tell(outcome, notes, f"{rows} rows of {log.table.num_columns} columns in {target}", report)


def _tell(outcome: dict[str, Any], notes: Iterable[str], written: str, report: Report) -> None:
    keep(outcome, report.common)
    for note in notes:
        report.line(note)
    report.line(written)
    report.summary(outcome)


def _check_target(file: Path, kind: str) -> None:
    """Raise InputError for a file that cannot be written, or is of another kind."""
    check_file_to_write(file)
    if file.suffix.lower() not in SUFFIXES[kind]:
        raise InputError(f"{kind} files end with {' or '.join(SUFFIXES[kind])}: {file.name}")
