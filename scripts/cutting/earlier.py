"""An earlier run as a start: gone on from, or its corrections taken to what has changed."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar, get_type_hints

from cyclopts import Parameter

from armside.arrays import Array
from armside.ilc.workbench.compare import RunState, read_states, save_states
from armside.sim.part.motion import Motion, carried
from armside.sim.records.run_folder import RUNS, RunFolder, check_writable
from armside.sim.records.stored_run import StoredRun, read_run
from armside.sim.robot_file.find import find_cell

from ..shell.errors import InputError
from ..shell.options import Common, options

STATE, KEY = "state.npz", "learning"
"""File with the states that a run can be gone on from, and the entry of a run with one loop."""
FREE = ("iterations", "repetitions", "plan_only", "wait", "start", "beyond")
"""Options that a run does not take over from an earlier one."""
BY_AXIS = "Axis by axis, arm-side angles of the motors at the same place of the contour"
"""Rule by which a correction is taken to another robot."""
Cfg = TypeVar("Cfg")


@options
@dataclass(frozen=True, kw_only=True)
class FromCfg:
    """Earlier run to start from."""

    start: Annotated[Path | None, Parameter(name="--from")] = None
    """Folder of an earlier run. Options not given are that run's. With none changed, learning goes
    on where it ended, or with --iterations 0 its last correction is repeated; otherwise its last
    correction is taken to the changed robot, payload or speed, and learning starts from there."""


@dataclass(frozen=True, eq=False)
class Earlier(Generic[Cfg]):
    """What an earlier run leaves to start from."""

    run: StoredRun
    states: Mapping[str, RunState | None] = field(repr=False)
    """By loop; None where a memory could not be stored."""
    options: Cfg
    """Of the earlier run."""
    seed: int
    """Of the earlier run."""
    changed: tuple[str, ...]
    """Options that differ."""
    repeats: bool
    """No update was asked for."""

    @property
    def goes_on(self) -> bool:
        """Learning goes on where it ended; elsewhere a correction alone is used."""
        return not self.changed and not self.repeats

    def state(self, key: str = KEY) -> RunState:
        """State after the last run of a loop. Raises InputError where none was stored."""
        found = self.states.get(key)
        if found is None:
            of = "" if key == KEY else f" of {key}"
            raise InputError(f"{self.run.folder} kept no state{of} to start from")
        return found

    def start(self, motion: Motion) -> Array | RunState:
        """Start of a cut: a state, or (N, n) [rad], the last correction on a motion. Raises
        InputError for another path."""
        state = self.state()
        return state if self.goes_on else self.taken(state, self.run.path, motion)

    def taken(self, state: RunState, before: Motion, motion: Motion) -> Array:
        """(N, n) [rad], a correction taken from one motion to another. Raises InputError where they
        follow different paths."""
        try:
            anywhere = "robot" in self.changed
            return carried(state.loop.correction, before, motion, anywhere=anywhere)
        except ValueError as error:
            raise InputError(f"{self.run.folder} cannot be started from: {error}") from error

    @property
    def entry(self) -> dict[str, Any]:
        """Entry of `summary.json`: what the run started from."""
        what = "last run" if self.goes_on else "correction"
        plural = "" if list(self.states) == [KEY] else "s"
        repeated = ", repeated" if self.repeats and not self.changed else ""
        k = max(state.loop.k for state in self.states.values() if state is not None)
        how = f"its {what}{plural}{repeated}"
        return {"run": str(self.run.folder), "k": k, "how": how, "changed": list(self.changed)}

    @property
    def line(self) -> str:
        """The same in a sentence."""
        where = f"k = {self.entry['k']} of {self.run.folder}"
        if self.goes_on:
            return f"Goes on from {where}"
        corrections = self.entry["how"].removeprefix("its ").removesuffix(", repeated")
        if not self.changed:
            return f"Repeats the {corrections} of {where}"
        text = f"Starts from the {corrections} of {where}; changed: {', '.join(self.changed)}"
        return f"{text}. {BY_AXIS}" if "robot" in self.changed else text


def started(
    start: Path | None, experiment: str, cfg: Cfg, common: Common
) -> tuple[Cfg, Common, Earlier[Cfg] | None]:
    """Options with those of the earlier run where none were given, and what it left. Raises
    InputError where no results can be written, for a folder that is no such run, one that diverged
    or stored no state, or options that do not go together."""
    check_writable(common.out or RUNS / experiment)
    if start is None:
        return cfg, common, None
    run = read_run(start)
    if run.experiment != experiment:
        raise InputError(f"{start} is a run of {run.experiment}, not of {experiment}")
    for row in run.summary.get("comparisons", ()):
        if row["diverged"]:
            lost = f"learning from {row['measure']} diverged at {row['pose']}"
            raise InputError(f"{run.folder} cannot be started from: {lost}")
    if experiment != "learn" and run.summary["status"] == "diverged":
        raise InputError(f"{run.folder} ended with status diverged: there is nothing to start from")
    stored = run.summary["config"]
    try:
        used, before, given = merged(cfg, stored)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{start}: its options cannot be used together with these: {error}"
        ) from error
    names = [each.name for each in fields(type(cfg)) if each.name not in FREE]  # pyright: ignore[reportArgumentType]
    changed = [name for name in names if getattr(used, name) != getattr(before, name)]
    if "robot" in changed and experiment == "compare":
        raise InputError(f"{start} has another robot: its poses, and so its cuts, are others")
    if "robot" in changed:
        refuse_other_axes(start, stored["robot"], getattr(used, "robot", ""))
    old_seed = stored.get("seed", 0)
    seed = common.seed or old_seed
    changed += ["seed"] if seed != old_seed else []
    if changed and getattr(used, "twin", None) is not None and experiment != "compare":
        if "twin" in given:
            raise InputError("give --twin or --from: each has a correction of its own")
        used = replace(used, twin=None)  # pyright: ignore[reportArgumentType]
    states = read_states(run.file(STATE))
    if not any(states.values()):
        raise InputError(f"{start} kept no state to start from")
    repeats = getattr(used, "iterations", 1) == 0
    left = Earlier(run, states, before, old_seed, tuple(changed), repeats)
    return used, replace(common, seed=seed), left


def refuse_other_axes(start: Path, robot: str, other: str) -> None:
    """Raise InputError where another robot has other axes than that of a run."""
    before, now = (find_cell(name).robot.slides for name in (robot, other))
    if before != now:
        text = f"{start} is a run of {robot} with {_axes(before)}, {other} has {_axes(now)}"
        raise InputError(f"{text}: a correction goes to a robot with as many axes of each kind")


def _axes(slides: tuple[bool, ...]) -> str:
    sliding = [str(i) for i, one in enumerate(slides, start=1) if one]
    return f"{len(slides)} axes" + (f", axis {' and '.join(sliding)} sliding" if sliding else "")


def merged(cfg: Cfg, stored: Mapping[str, Any]) -> tuple[Cfg, Cfg, list[str]]:
    """Options as given now, elsewhere those of an earlier run as its summary has them; those of
    that run; and the names of options that were given. Raises TypeError or ValueError for options
    that do not go together."""
    kind: Any = type(cfg)
    names = [each.name for each in fields(kind) if each.name in stored]
    before = kind(**{name: _typed(kind, name, stored[name]) for name in names})
    given = _given(cfg)
    taken = {name: getattr(before, name) for name in _given(before) if name not in FREE}
    return kind(**taken | {name: getattr(cfg, name) for name in given}), before, given


def _given(cfg: Any) -> list[str]:
    """Names of options that are not what their defaults make of the others."""
    found = []
    for each in fields(cfg):
        with suppress(ValueError):  # where the default does not fit the others, it was given
            usual = replace(cfg, **{each.name: each.default})
            if getattr(usual, each.name) == getattr(cfg, each.name):
                continue
        found.append(each.name)
    return found


def _typed(kind: Any, name: str, stored: Any) -> Any:
    if isinstance(stored, list):
        return tuple(stored)
    hint = get_type_hints(kind)[name]
    is_path = hint is Path or Path in getattr(hint, "__args__", ())
    return Path(stored) if is_path and isinstance(stored, str) else stored


def save_state(folder: RunFolder, state: RunState | None) -> None:
    """Write the state that the next run goes on from; none of a run without a loop."""
    if state is not None:
        save_states(folder / STATE, {KEY: state})
