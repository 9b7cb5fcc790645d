"""Run of an experiment on disk: options, results, signals, programmed path and robot."""

import json
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .files import LARGEST_DATA, InputError, check_file, reading
from .run_folder import FORMAT

if TYPE_CHECKING:
    import mujoco

    from ..motion.tool_motion import ToolMotion
    from ..part.motion import PartMotion
    from .signals import Signals


@dataclass(frozen=True)
class StoredRun:
    """Finished run in a folder. Its files are read when they are asked for."""

    folder: Path
    summary: dict[str, Any]
    """Content of summary.json; the options are under `config`."""

    @property
    def experiment(self) -> str:
        """Name of the command that made it."""
        return self.summary["config"]["experiment"]

    def file(self, name: str) -> Path:
        """Path of one of its files. Raises InputError where the run has no such file."""
        if not (file := self.folder / name).exists():
            raise InputError(f"{self.folder} has no {name}: {self._writer} wrote none")
        return check_file(file, LARGEST_DATA)

    @property
    def _writer(self) -> str:
        return f"`{self.experiment}` of armside {_version(self.summary)}"

    @cached_property
    def signals(self) -> "Signals":
        """All recorded signals. Raises InputError where the file is missing or foreign."""
        from .signals import read_signals

        file = self.file("signals.parquet")
        with reading(file):
            return read_signals(file)

    @property
    def path(self) -> "ToolMotion | PartMotion":
        """Programmed tool motion. Raises InputError for a run that has none."""
        if self.signals.path is None:
            missing = f"no programmed path: {self._writer} stored none; run it again"
            raise InputError(f"{self.folder} holds {missing}")
        return self.signals.path

    @cached_property
    def robot(self) -> "mujoco.MjModel":
        """Robot as its replay draws it. Raises InputError where the run has none."""
        import mujoco

        file = self.file("robot.xml")
        with reading(file):
            return mujoco.MjModel.from_xml_path(str(file))


def read_run(folder: str | PathLike[str]) -> StoredRun:
    """Open the folder of a run. Raises InputError for no run, or one of another format."""
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder} is no folder; give the folder of a run, such as runs/laser-...")
    file = folder / "summary.json"
    if not file.is_file():
        raise InputError(f"{folder} is no run's folder: it has no summary.json")
    with reading(check_file(file)):
        summary = json.loads(file.read_text(encoding="utf-8"))
    config = summary.get("config") if isinstance(summary, dict) else None
    if not (isinstance(config, dict) and isinstance(config.get("experiment"), str)):
        raise InputError(f"{file} is no summary of a run: it names no experiment")
    seed = config.get("seed", 0)
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(f"{file}: seed must be a whole number >= 0, got {seed!r}")
    found = summary.get("format", 0)
    if found != FORMAT:
        formats = f"in format {found}, this one reads {FORMAT}; run it again"
        raise InputError(f"{folder} was written by armside {_version(summary)} {formats}")
    return StoredRun(folder, summary)


def _version(summary: dict[str, Any]) -> str:
    return summary["config"].get("versions", {}).get("armside", "an unknown version")
