"""Starts of the laws of `armside learn`: an earlier run, or a file with a correction."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armside.arrays import Array
from armside.ilc.workbench.compare import RunState
from armside.ilc.workbench.signals import CsvSignal
from armside.ilc.workbench.task import along_path
from armside.sim.controller.stored_correction import REFERENCE, read_correction

from ..cutting.earlier import Earlier, started
from ..shell.options import Common
from .law_results import key
from .options import LearnCfg
from .plant_option import named_task, refuse_other_path

if TYPE_CHECKING:
    from armside.ilc.workbench.task import Task


@dataclass(frozen=True, eq=False)
class Starts:
    """What each law starts from: a run, a correction, or nothing."""

    place: Path | None = None
    """Folder of the run, or file with the correction."""
    of: Earlier[LearnCfg] | None = None
    given: CsvSignal | None = field(default=None, repr=False)

    def state(self, law: str, noise: float, repetition: int) -> RunState | None:
        """State to go on from; None where a correction alone is used."""
        goes_on = self.of is not None and self.of.goes_on
        return self.of.state(key(law, noise, repetition)) if self.of and goes_on else None

    def correction(self, law: str, task: "Task") -> Array | None:
        """u of the last run with the same law, or else with the first; None where it goes on. Where
        both tasks follow a path at other speeds, it is taken by the place there. Raises InputError
        where a robot follows another path."""
        if self.given is not None:
            return self.given.at(len(task.reference), task.sample_time)
        if self.of is None or self.of.goes_on:
            return None
        stored = {name: state for name, state in self.of.states.items() if state is not None}
        same = [state for name, state in stored.items() if name.startswith(f"{law} | ")]
        found = (same or list(stored.values()))[0].loop.correction
        if "plant" not in self.of.changed or task.place is None:
            return found
        refuse_other_path(self.of.options.plant, task.name)
        before = named_task(self.of.options, self.of.seed)
        return found if before.place is None else along_path(found, before.place, task.place)

    @property
    def followed(self) -> Path | None:
        """Reference of a run that is gone on from; None where it may be another, or is missing. The
        noise of a robot goes on from run to run, so that one that is only listened to counts."""
        if self.of is None or not self.of.goes_on:
            return None
        file = self.of.run.folder / REFERENCE
        return file if file.is_file() else None

    @property
    def entry(self) -> dict[str, Any] | None:
        """Entry of `summary.json`."""
        if self.of is None and self.place is not None:
            return {"run": str(self.place), "how": "its correction", "changed": []}
        return None if self.of is None else self.of.entry

    @property
    def lines(self) -> list[str]:
        """The same in a sentence, if there is anything."""
        if self.of is None:
            return [] if self.place is None else [f"Starts from the correction of {self.place}"]
        return [self.of.line]


def starts(cfg: LearnCfg, common: Common) -> tuple[LearnCfg, Common, Starts]:
    """Options with those of the earlier run where none were given, and what it left. Raises
    InputError for a folder that is no run of `armside learn`, or without states."""
    start = cfg.start
    if start is not None and start.is_file():
        cfg, common, _ = started(None, "learn", cfg, common)
        return cfg, common, Starts(start, given=read_correction(start))
    cfg, common, before = started(start, "learn", cfg, common)
    return cfg, common, Starts(start, before)
