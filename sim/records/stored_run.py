"""A run's folder, read back: what was asked, what came out, every signal."""

import json
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

from .errors import InputError
from .signals import Signals, read_signals
from .summary import FORMAT

PATHS = ("model", "contour", "identification")
"""Options that are files or folders."""


@dataclass(frozen=True)
class StoredRun:
    """A finished run on disk."""

    path: Path
    summary: dict[str, Any]

    @property
    def experiment(self) -> str:
        """The command that made it."""
        return self.summary["config"]["experiment"]

    @property
    def signals_file(self) -> Path:
        """Where its signals are. Raises InputError where the experiment wrote none."""
        file = self.path / "signals.parquet"
        if not file.is_file():
            raise InputError(f"{self.path} has no signals.parquet: `{self.experiment}` writes none")
        return file

    @cached_property
    def signals(self) -> Signals:
        """Everything that was recorded. Raises InputError where the file is missing or foreign."""
        try:
            return read_signals(self.signals_file)
        except (ValueError, OSError, KeyError) as error:
            raise InputError(str(error)) from error

    def configuration(self, kind: type) -> Any:
        """The options it was run with, as the dataclass of its command.

        Raises InputError where this version no longer knows an option's value.
        """
        stored = self.summary["config"]
        given = {}
        for field in fields(kind):
            value = stored.get(field.name)
            if isinstance(value, list):
                value = tuple(value)
            if field.name in stored:
                given[field.name] = value
        given |= {name: Path(given[name]) for name in PATHS if given.get(name) is not None}
        try:
            return kind(**given)
        except (ValueError, TypeError) as error:
            raise InputError(f"{self.path} was run with options unknown here: {error}") from error


def read_run(path: Path) -> StoredRun:
    """Open a run's folder.

    Raises:
        InputError: no such folder, no run in it, or one of another format.
    """
    if not path.is_dir():
        raise InputError(f"{path} is no folder; give the folder of a run, such as runs/laser-...")
    file = path / "summary.json"
    if not file.is_file():
        raise InputError(f"{path} is no run's folder: it has no summary.json")
    try:
        summary = json.loads(file.read_text(encoding="utf-8"))
    except (ValueError, OSError) as error:
        raise InputError(f"{file} cannot be read: {error}") from error
    if not (isinstance(summary, dict) and isinstance(summary.get("config"), dict)):
        raise InputError(f"{file} is no summary of a run")
    found = summary.get("format", 0)
    if found != FORMAT:
        made = summary["config"].get("versions", {}).get("armside", "an unknown version")
        raise InputError(
            f"{path} was written by armside {made} in format {found}, this one reads {FORMAT}; "
            f"run it again"
        )
    return StoredRun(path, summary)
