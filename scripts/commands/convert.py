"""`armside convert`: a run's signals, or a recording of a real arm, for other tools."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from armside.sim.records import read_run
from armside.sim.records.files import check_file_to_write
from armside.sim.records.run_folder import check_destination, check_writable
from armside.sim.records.summary import summary

from ..shell.bag_options import BagCfg
from ..shell.console import Report
from ..shell.errors import InputError, checking_input
from ..shell.options import Common, FileToRead, options

Kind = Literal["csv", "parquet", "mat", "hdf5", "mcap"]
SUFFIXES = {kind: [f".{kind}"] for kind in get_args(Kind)} | {"hdf5": [".hdf5", ".h5"]}


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
    from armside.sim.recordings.logs.controller_log import SUFFIXES as LOGS

    report = Report(common)
    is_log = source.is_file() and source.suffix.lower() in LOGS
    if cfg.columns is not None and not is_log:
        raise InputError(f"{source} is no log of a controller: --columns is of those")
    if is_log or (source / "summary.json").exists() or not is_motion(source):
        found, written = _table(source, cfg, is_log=is_log)
    else:
        found, written = _recording(source, cfg)
    outcome = summary("convert", cfg, common, source=source, **found)
    report.kept(outcome, *found.get("notes", ()), written)


def _table(source: Path, cfg: ConvertCfg, *, is_log: bool) -> tuple[dict[str, Any], str]:
    from armside.sim.recordings.logs import read_log
    from armside.sim.records.tables import read_table, write_table

    if cfg.topics().named:
        raise InputError(
            f"topics and joints are chosen in bags, not in {'logs' if is_log else 'runs'}"
        )
    run = None if is_log else read_run(source)
    beside = source.with_name(f"{source.stem}-signals.{cfg.to}")
    file = cfg.file or (beside if is_log else source / f"signals.{cfg.to}")
    check_file_to_write(file)
    if file.suffix.lower() not in SUFFIXES[cfg.to]:
        raise InputError(f"{cfg.to} files end with {' or '.join(SUFFIXES[cfg.to])}: {file.name}")
    with checking_input():
        if run is None:
            log = read_log(source, cfg.columns)
            table, about = log.table, {"form": log.form, "notes": list(log.notes)}
        else:
            table, about = read_table(run.file("signals.parquet")), {}
    write_table(file, table)
    written = f"{table.num_rows} rows of {table.num_columns} columns in {file}"
    return {"file": file, "rows": table.num_rows} | about, written


def _recording(source: Path, cfg: ConvertCfg) -> tuple[dict[str, Any], str]:
    from armside.sim.recordings import read_motion
    from armside.sim.recordings.bags.write import write_bag
    from armside.sim.recordings.tables import write_motion_tables
    from armside.sim.records.atomic import staged

    folder = cfg.file or source.absolute().parent / f"{source.stem}-{cfg.to}"
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
    found = {"folder": folder, "samples": samples, "form": recording.form}
    written = ", ".join(f"{n} of {name}" for name, n in samples.items())
    return found | {"notes": list(recording.notes)}, f"{written} in {folder}"
