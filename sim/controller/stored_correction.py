"""Correction that a stored run ended with and its reference, or a correction in a file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array, check_recorded_time
from armside.ilc.workbench.signals import CsvSignal, read_signal
from armside.ilc.workbench.words import Words

from ..notes import GROWTH
from ..records.files import InputError, reading
from ..records.stored_run import StoredRun
from ..records.tables import float_columns, floats, numbered, read_table
from .gate import STATES

REFERENCE = "reference.csv"
"""File with the reference in a run of `armside learn`."""
DIVERGED, DONE = "diverged", "done"
ROBOTS = ("large", "irb1400")
OF_ANGLES = ("two-mass", "egm", "rsi")
"""Other plants of `armside learn` whose signals are angles."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StoredCorrection:
    """u of a run's last iteration."""

    correction: Array = field(repr=False)
    """u_k, shape (N, n); [rad] on a robot."""
    reference: Array = field(repr=False)
    """r, shape (N, n)."""
    sample_time: float
    """[s]."""
    k: int
    """Iteration that ran with it."""
    robot: str | None
    """Robot by name or file; None for a plant that is none, or not known."""
    unit: str = "rad"
    """Of both; 1 where it is not known, of an own plant."""
    law: str | None = None
    """Words of the law, of a run that compared laws."""
    ended: Mapping[str, str] = field(default_factory=dict)
    """How the run ended, by the names of `gate`; empty where it ended well."""


def stored_correction(run: StoredRun, law: str | None = None) -> StoredCorrection:
    """Correction of a run of laser, cut or learn. law: which, where learn compared several.

    Raises InputError for another run, or a law that it does not have.
    """
    if run.experiment == "learn":
        return _of_learn(run, law)
    if run.experiment not in ("laser", "cut"):
        runs = "runs of laser, cut and learn have"
        raise InputError(f"{run.folder} is a run of {run.experiment}: {runs} a correction")
    if law is not None:
        raise InputError(f"{run.folder} is a run of {run.experiment}, with one law: leave it out")
    if run.summary["config"].get("as_program"):
        kept = "its correction is in the targets of its program, not in samples of the motors"
        raise InputError(f"{run.folder} was run as a program: {kept}")
    last = run.signals.runs[-1]
    log = last.recording
    return StoredCorrection(
        correction=log.correction,
        reference=log.reference,
        sample_time=float(log.time[1] - log.time[0]),
        k=last.k,
        robot=run.summary["config"]["robot"],
        ended=ended(run.summary, last.k),
    )


def ended(summary: Mapping[str, Any], k: int) -> dict[str, str]:
    """What holds the correction of iteration k back by names of `gate`: notes, end of the run."""
    states = {cause.value: name for cause, name in STATES.items()}
    found: dict[str, str] = {}
    for note in summary.get("notes", ()):
        if note["cause"] in states and k in (note["runs"] or [k]):
            found.setdefault(states[note["cause"]], note["text"])
    if (end := summary["status"]) != DONE:
        found.setdefault(end, f"the run ended as {end} at k = {k}")
    return found


def _of_learn(run: StoredRun, law: str | None) -> StoredCorrection:
    first: dict[Any, dict[str, Any]] = {}  # repetition of each law and noise level
    for row in run.summary["laws"]:
        first.setdefault((row["law"], row["noise"]), row)
    rows = list(first.values())
    names = list(dict.fromkeys(row["law"] for row in rows))
    if law is None and len(names) > 1:
        raise InputError(f"{run.folder} has several laws, give one: {', '.join(names)}")
    if law is not None and law not in names:
        raise InputError(f"{run.folder} has no law {law!r}. It has: {', '.join(names)}")
    at = next(i for i, row in enumerate(rows) if law in (None, row["law"]))
    (file,) = run.folder.glob(f"correction-{at + 1}-*.csv")
    signal, reference = read_signal(file), read_signal(run.file(REFERENCE))
    if signal.time is None:
        raise InputError(f"{file} has no column time")
    robot, unit = _robot(run.summary["config"])
    row, states = rows[at], dict[str, str]()
    if row["diverged"]:
        states[DIVERGED] = "learning diverged"
    if (tool := row.get("arm_rms")) and not tool[-1] <= GROWTH * tool[0]:
        text = f"RMS {1e6 * tool[0]:.4g} to {1e6 * tool[-1]:.4g} um"
        states["worse"] = f"learning made the tool worse: {text}"
    return StoredCorrection(
        correction=signal.values,
        reference=reference.values,
        sample_time=float(signal.time[1] - signal.time[0]),
        k=row["first_k"] + len(row["error_two"]) - 1,
        robot=robot,
        unit=unit,
        law=row["law"],
        ended=states,
    )


def _robot(config: dict[str, Any]) -> tuple[str | None, str]:
    """Robot that the words of the plant name, and unit of its angles."""
    try:
        name = Words.parse(config["plant"]).name
    except ValueError:
        return None, "1"
    if name in ROBOTS or Path(name).suffix == ".toml":
        return name, "rad"
    return None, "rad" if name in OF_ANGLES else "1"


def read_correction(file: Path) -> CsvSignal:
    """Columns correction_1, ... (or u_1, ...), and time [s] if it has that, of a CSV, MAT, HDF5 or
    Parquet file. Raises InputError for other columns, missing values, a time that does not
    increase."""
    table = read_table(file)
    names = numbered(table, "correction_{}") or numbered(table, "u_{}")
    if not names:
        found = ", ".join(table.column_names[:4])
        raise InputError(f"{file} holds no correction: no column correction_1, but {found}")
    values = float_columns(table, names)
    time = floats(table, "time") if "time" in table.column_names else None
    if not np.isfinite(values).all():
        raise InputError(f"{file}: values of the correction are missing or not finite")
    if time is not None:
        if len(time) < 2:
            raise InputError(f"{file}: at least 2 rows are needed, got {len(time)}")
        with reading(file):
            check_recorded_time(file.name, time)
    return CsvSignal(file, time, values)
