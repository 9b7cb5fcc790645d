"""An earlier `armside compare` as a start: every way gone on from, or its correction taken over."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from armside.ilc.workbench.compare import RunState, read_states, save_states
from armside.sim.laser.comparison import Case
from armside.sim.laser.learning import Begin
from armside.sim.part.carried import carried
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.stored_run import read_run

from ..shell.errors import InputError
from ..shell.options import Common
from .carried_options import carried_options
from .earlier import STATE

FREE = ("iterations", "imu")
"""Options that a run does not take over from an earlier one."""
Cfg = TypeVar("Cfg")


@dataclass(frozen=True, kw_only=True, eq=False)
class EarlierComparison:
    """What an earlier comparison leaves to start from."""

    folder: Path
    cases: Sequence[Case]
    """Of the earlier run."""
    states: Mapping[str, RunState] = field(repr=False)
    """By `key`."""
    changed: tuple[str, ...]
    """Options that differ."""

    def begins(self, number: int, case: Case) -> dict[str, Begin]:
        """Beginning of each way to learn a case. InputError where it was not cut at this pose."""
        if not self.changed:
            return {way: Begin(resume=state) for way, state in self._of(number).items()}
        before = self._same_place(case)
        old, new = (each.experiment().motion for each in (self.cases[before], case))
        try:
            return {
                way: Begin(start=carried(state.loop.correction, old, new))
                for way, state in self._of(before).items()
            }
        except ValueError as error:
            raise InputError(f"{self.folder} cannot be started from: {error}") from error

    def _of(self, number: int) -> dict[str, RunState]:
        return {
            name.partition(" ")[2]: state
            for name, state in self.states.items()
            if name.startswith(f"{number} ")
        }

    def _same_place(self, case: Case) -> int:
        """Number of the earlier case at this pose, by preference at this speed and limit."""
        cut, poses = case.cut, [each.cut.pose for each in self.cases]
        at = [i for i, pose in enumerate(poses) if pose == cut.pose]
        if not at:
            known = ", ".join(dict.fromkeys(map(str, poses)))
            raise InputError(f"{self.folder} has no cut at {cut.pose}. It has: {known}")

        def differences(i: int) -> int:
            other = self.cases[i].cut
            return (other.speed != cut.speed) + (other.limits != cut.limits)

        return min(at, key=differences)

    @property
    def entry(self) -> dict[str, Any]:
        """Entry of `summary.json`: what the comparison started from."""
        how = "its corrections" if self.changed else "its last runs"
        k = max(state.loop.k for state in self.states.values())
        return {"run": str(self.folder), "k": k, "how": how, "changed": list(self.changed)}

    @property
    def line(self) -> str:
        """The same in a sentence."""
        where = f"k = {self.entry['k']} of {self.folder}"
        if self.changed:
            return f"Starts from the corrections of {where}; changed: {', '.join(self.changed)}"
        return f"Goes on from {where}"


def key(number: int, way: str) -> str:
    """Key of a state: number of the case, and way to learn it."""
    return f"{number} {way}"


def earlier_comparison(
    start: Path, cfg: Cfg, common: Common, cases_of: Callable[[Cfg, int], Sequence[Case]]
) -> tuple[Cfg, Common, EarlierComparison]:
    """Options with those of the earlier comparison where none were given, and what it left.

    Raises InputError for a folder that is no comparison, or one with a way that diverged.
    """
    run = read_run(start)
    if run.experiment != "compare":
        raise InputError(f"{start} is a run of {run.experiment}, not of compare")
    for row in run.summary["comparisons"]:
        if row["diverged"]:
            lost = f"learning from {row['measure']} diverged at {row['pose']}"
            raise InputError(f"{start} cannot be started from: {lost}")
    stored = run.summary["config"]
    found = carried_options(cfg, stored, FREE)
    if "robot" in found.changed:
        raise InputError(f"{start} has another robot: its poses, and so its cuts, are others")
    old_seed = stored.get("seed", 0)
    seed = common.seed or old_seed
    changed = (*found.changed, *(["seed"] if seed != old_seed else []))
    states = {name: state for name, state in read_states(run.file(STATE)).items() if state}
    made = EarlierComparison(
        folder=start,
        cases=cases_of(found.before, old_seed),
        states=states,
        changed=changed,
    )
    return found.options, replace(common, seed=seed), made


def save_all(folder: RunFolder, states: Sequence[Mapping[str, RunState]]) -> None:
    """Write the states of every way of every case."""
    named = {key(i, way): state for i, of in enumerate(states) for way, state in of.items()}
    save_states(folder / STATE, named)
