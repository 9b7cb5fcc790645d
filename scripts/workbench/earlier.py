"""An earlier run of `armside learn` as a start: continued, or its corrections taken over.

A file with a correction is a start as well.
"""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armside.arrays import Array
from armside.ilc.workbench.csv_signal import CsvSignal
from armside.ilc.workbench.state import RunState, read_states
from armside.ilc.workbench.transfer import along_path
from armside.sim.controller.stored_correction import REFERENCE, read_correction
from armside.sim.records.stored_run import read_run

from ..shell.errors import InputError
from ..shell.options import Common
from .options import LearnCfg
from .plants import named_task
from .results import STATE, key
from .same_path import refuse_other_path

if TYPE_CHECKING:
    from armside.ilc.workbench.task import Task

FREE = ("iterations", "start", "wait")
"""Options that a continued run need not share with the earlier one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Earlier:
    """States of an earlier run and whether this one continues it."""

    folder: Path
    states: Mapping[str, RunState | None]
    continues: bool
    changed: tuple[str, ...] = ()
    """Options that differ from the earlier run's."""
    options: LearnCfg
    """Of the earlier run."""
    seed: int
    """Of the earlier run."""
    given: CsvSignal | None = None
    """Correction of a file, which is all there is then."""

    def state(self, law: str, noise: float, repetition: int) -> RunState | None:
        """State to continue; None where the run starts anew. InputError if it was not kept."""
        if not self.continues:
            return None
        found = self.states.get(key(law, noise, repetition))
        if found is None:
            raise InputError(f"{self.folder} kept no state of {law}: it cannot be continued")
        return found

    def correction(self, law: str, task: "Task") -> Array | None:
        """u of the last run with the same law, or else with the first; None when continued.

        Where both tasks follow a path at other speeds, it is carried over by the place there.
        Raises InputError where a robot follows another path.
        """
        if self.continues:
            return None
        if self.given is not None:
            return self.given.at(len(task.reference), task.sample_time)
        kept = {each: state for each, state in self.states.items() if state is not None}
        same = [state for each, state in kept.items() if each.startswith(f"{law} | ")]
        first = (same or list(kept.values()))[:1]
        if not first:
            return None
        found = first[0].loop.correction
        if "plant" not in self.changed or task.place is None:
            return found
        refuse_other_path(self.options.plant, task.name)
        before = named_task(self.options, self.seed)
        return found if before.place is None else along_path(found, before.place, task.place)

    @property
    def followed(self) -> Path | None:
        """Reference of a run that is continued; None where it may be another one, or was not kept.

        The noise of a robot goes on from run to run, so that one that is only listened to counts.
        """
        file = self.folder / REFERENCE
        return file if self.continues and file.is_file() else None

    @property
    def entry(self) -> dict[str, Any]:
        """Entry of `summary.json`: what the run started from."""
        how = "continued" if self.continues else "started from its correction"
        return {"run": str(self.folder), "how": how, "changed": list(self.changed)}

    @property
    def line(self) -> str:
        """The same in a sentence."""
        if self.continues:
            return f"Goes on from the last run of {self.folder}"
        changed = f"; changed: {', '.join(self.changed)}" if self.changed else ""
        return f"Starts from the correction of {self.folder}{changed}"


def earlier(cfg: LearnCfg, common: Common) -> tuple[LearnCfg, Common, Earlier | None]:
    """Options with those of the earlier run where none were given, and its states.

    Raises InputError for a folder that is no run of `armside learn`, or without states.
    """
    if cfg.start is None:
        return cfg, common, None
    if cfg.start.is_file():
        found = Earlier(
            folder=cfg.start,
            states={},
            continues=False,
            options=cfg,
            seed=common.seed,
            given=read_correction(cfg.start),
        )
        return cfg, common, found
    run = read_run(cfg.start)
    if run.experiment != "learn":
        raise InputError(f"{cfg.start} is a run of {run.experiment}, not of learn")
    stored = run.summary["config"]
    merged = {each.name: _option(cfg, each, stored) for each in fields(cfg)}
    try:
        result = replace(cfg, **merged)
    except (TypeError, ValueError) as error:
        raise InputError(f"{cfg.start}: its options cannot be used: {error}") from error
    seed = common.seed or stored.get("seed", 0)
    changed = [
        name
        for name, value in merged.items()
        if name not in FREE and name in stored and value != _typed(value, stored[name])
    ]
    changed += ["seed"] if seed != stored.get("seed", seed) else []
    kept = {each.name: stored[each.name] for each in fields(cfg) if each.name in stored}
    kept |= {"start": None}
    before = LearnCfg(**{name: _typed(None, value, name) for name, value in kept.items()})
    states = read_states(run.file(STATE))
    if not any(states.values()):
        raise InputError(f"{cfg.start} kept no state to start from")
    found = Earlier(
        folder=cfg.start,
        states=states,
        continues=not changed,
        changed=tuple(changed),
        options=before,
        seed=stored.get("seed", 0),
    )
    return result, replace(common, seed=seed), found


def _option(cfg: LearnCfg, field: Any, stored: Mapping[str, Any]) -> Any:
    """The option as given, or that of the earlier run if it was left at its default."""
    given = getattr(cfg, field.name)
    default = field.default if field.default is not MISSING else None
    if field.name in FREE or given != default or field.name not in stored:
        return given
    return _typed(given, stored[field.name], field.name)


def _typed(like: Any, stored: Any, name: str = "") -> Any:
    if isinstance(stored, list):
        return tuple(stored)
    if stored is not None and (isinstance(like, Path) or name == "model"):
        return Path(stored)
    return stored
