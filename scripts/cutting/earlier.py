"""An earlier run of `armside laser` or `cut` as a start: gone on from, or its correction taken."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from cyclopts import Parameter

from armside.arrays import Array
from armside.ilc.learning import LoopState
from armside.ilc.workbench.compare import RunState, read_states, save_states
from armside.sim.cell_file import find_cell
from armside.sim.laser.resume import state_after
from armside.sim.part.carried import Motion, carried
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.stored_run import StoredRun, read_run

from ..shell.console import Report
from ..shell.errors import InputError
from ..shell.options import Common, options
from .carried_options import carried_options

STATE, KEY = "state.npz", "learning"
"""File with the state that a run can be gone on from, and its entry."""
FREE = ("iterations", "repetitions", "plan_only")
"""Options that a run does not take over from an earlier one."""
BY_AXIS = "Axis by axis, arm-side angles of the motors at the same place of the contour"
"""Rule by which a correction is taken to another robot."""
ENDED = "diverged"
Cfg = TypeVar("Cfg")


@options
@dataclass(frozen=True, kw_only=True)
class FromCfg:
    """Earlier run to start from."""

    start: Annotated[Path | None, Parameter(name="--from")] = None
    """Folder of an earlier run. Options not given are that run's. With none changed, learning goes
    on where it ended, or with --iterations 0 its last correction is repeated; otherwise its last
    correction is taken to the changed robot, payload or speed, and learning starts from there."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Earlier:
    """What an earlier run leaves to start from."""

    run: StoredRun
    state: RunState = field(repr=False)
    changed: tuple[str, ...]
    """Options that differ."""
    repeats: bool
    """No update was asked for."""

    @property
    def resume(self) -> RunState | None:
        """State to go on from; None where its correction alone is used."""
        return None if self.changed or self.repeats else self.state

    def correction(self, motion: Motion) -> Array:
        """(N, n) [rad], its last correction on a motion. InputError for another path."""
        try:
            loop, path = self.state.loop, self.run.path
            found = carried(loop.correction, path, motion, anywhere=self.other_robot)
        except ValueError as error:
            raise InputError(f"{self.run.folder} cannot be started from: {error}") from error
        return np.array(found)

    @property
    def other_robot(self) -> bool:
        """The correction is taken to another robot."""
        return "robot" in self.changed

    @property
    def how(self) -> str:
        if self.changed:
            return "its correction"
        return "its correction, repeated" if self.repeats else "its last run"

    @property
    def entry(self) -> dict[str, Any]:
        """Entry of `summary.json`: what the run started from."""
        about = {"run": str(self.run.folder), "k": self.state.loop.k, "how": self.how}
        return about | {"changed": list(self.changed)}

    @property
    def line(self) -> str:
        """The same in a sentence."""
        where = f"k = {self.state.loop.k} of {self.run.folder}"
        if self.changed:
            said = f"Starts from the correction of {where}; changed: {', '.join(self.changed)}"
            return f"{said}. {BY_AXIS}" if self.other_robot else said
        return f"{'Repeats the correction of' if self.repeats else 'Goes on from'} {where}"


def earlier(
    start: Path, experiment: str, cfg: Cfg, common: Common, iterations: int
) -> tuple[Cfg, Common, Earlier]:
    """Options with those of the earlier run where none were given, and what it left.

    Raises InputError for a folder that is no such run, or one that diverged.
    """
    run = read_run(start)
    if run.experiment != experiment:
        raise InputError(f"{start} is a run of {run.experiment}, not of {experiment}")
    if run.summary["status"] == ENDED:
        raise InputError(f"{start} ended with status {ENDED}: there is nothing to start from")
    stored = run.summary["config"]
    found = carried_options(cfg, stored, FREE)
    if "robot" in found.changed:
        robot = getattr(found.options, "robot")  # noqa: B009 - of laser and of cut
        refuse_other_axes(start, stored["robot"], robot)
    seed, used = common.seed or stored.get("seed", 0), found.options
    changed = [*found.changed, *(["seed"] if seed != stored.get("seed", 0) else [])]
    if changed and getattr(used, "twin", None) is not None:
        if "twin" in found.given:
            raise InputError("give --twin or --from: each has a correction of its own")
        used = replace(used, twin=None)  # pyright: ignore[reportArgumentType]
    state = read_states(run.file(STATE)).get(KEY)
    if state is None:
        raise InputError(f"{start} kept no state to start from")
    made = Earlier(run=run, state=state, changed=tuple(changed), repeats=iterations == 0)
    return used, replace(common, seed=seed), made


def refuse_other_axes(start: Path, robot: str, other: str) -> None:
    """Raise InputError where another robot has other axes than that of a run."""
    before, now = (find_cell(name).robot.slides for name in (robot, other))
    if before != now:
        said = f"{start} is a run of {robot} with {_axes(before)}, {other} has {_axes(now)}"
        raise InputError(f"{said}: a correction goes to a robot with as many axes of each kind")


def _axes(slides: tuple[bool, ...]) -> str:
    sliding = [str(i) for i, one in enumerate(slides, start=1) if one]
    return f"{len(slides)} axes" + (f", axis {' and '.join(sliding)} sliding" if sliding else "")


def save_state(folder: RunFolder, state: RunState | None) -> None:
    """Write the state that the next run goes on from; none of a run without a loop."""
    if state is not None:
        save_states(folder / STATE, {KEY: state})


def kept_state(loop: LoopState | None, plant: Any, start: Array | None) -> RunState | None:
    """As `state_after`; None where there is no loop."""
    return None if loop is None else state_after(loop, plant, start)


def show_transfer(report: Report, before: Earlier, without: float | None, rows: list[Any]) -> None:
    """Print what a run started from; where it was taken over, the error with and without it."""
    report.line(before.line)
    first = rows[0]["arm_rms"]
    if without is not None and first is not None:
        figures = f"{1e6 * first:.4g} um, {1e6 * without:.4g} um without it"
        report.line(f"Its first run, with that correction: RMS {figures}")
