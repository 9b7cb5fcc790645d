"""Options of `armside compare`, and the cuts that they name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from armside.ilc.workbench.compare import RunState, save_states
from armside.sim.cell import pose
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.comparison import Case
from armside.sim.laser.experiment import Iteration
from armside.sim.laser.loop import Start
from armside.sim.laser.specification import Cut
from armside.sim.motion.timing import PathLimits
from armside.sim.records.run_folder import RunFolder
from armside.sim.robot_file.find import find_cell

from ..shell.effort import refuse_absurd
from ..shell.errors import InputError
from ..shell.options import PERCENT, SEVERAL, Limits, check_limits, options
from .earlier import STATE, Earlier
from .options import OF_ROBOT, KnownGearsCfg, known_state
from .specification import effort

RADIUS = 0.005
"""[m], of the circles."""
MEASURES = 4
"""Ways to learn each cut."""


@options
@dataclass(frozen=True, kw_only=True)
class CompareCfg(KnownGearsCfg):
    """Cuts of one robot."""

    robot: str = "large"
    """Robot: large, irb1400, or a robot file (.toml)."""
    poses: Annotated[tuple[str, ...], SEVERAL] = ()
    """Named poses [default: all of the robot; p1, p2 and p3 of thesis (9.3) of the large one]."""
    speeds: Annotated[tuple[float, ...], SEVERAL] = (40.0, 100.0)
    """Programmed speeds [mm/s]."""
    raised_acceleration: float = 2.2
    """Raised limit: cuts whose speed the controller lowers are also made with it [m/s^2]."""
    iterations: int = 10
    """Number of updates; one run more is made."""
    stiffness_error: float = 30.0
    """Error of the assumed stiffness of each axis, uniform up to this, drawn with the seed [%]."""
    law: Literal["inverse", "norm-optimal", "heuristic"] = "inverse"
    """Law on the arm side; the motor side has the thesis's heuristic."""
    twin: Path | None = None
    """Folder of `armside commission` for this robot: also cut right at the first run by this twin,
    and learned on from the motors."""

    def __post_init__(self) -> None:
        super().__post_init__()
        known = find_cell(self.robot).poses
        object.__setattr__(self, "poses", self.poses or tuple(known))
        if self.gears is not None and self.twin is not None:
            raise ValueError("give gears or twin, not both: a twin knows gear errors of its own")
        for name in self.poses:
            pose(name, known)
        if not self.speeds:
            raise ValueError("speeds takes one value or more, got none")
        check_limits(
            self,
            {"speeds": OF_ROBOT["speed"], "iterations": Limits(1), "stiffness_error": PERCENT},
        )
        PathLimits(acceleration=self.raised_acceleration)


def cases_of(cfg: CompareCfg, seed: int) -> list[Case]:
    """Each pose and speed; a speed that the controller lowers also with its limit raised."""
    robot, found = known_state(cfg, find_cell(cfg.robot).robot), list[Case]()
    for speed in cfg.speeds:
        limits = [PathLimits()]
        if speed * 1e-3 > PathLimits().cornering_speed(RADIUS):
            limits.append(PathLimits(acceleration=cfg.raised_acceleration))
        for limit, name in product(limits, cfg.poses):
            cut = Cut(
                robot=cfg.robot, pose=name, speed=speed * 1e-3, limits=limit, imu=ImuCfg(), **robot
            )
            found.append(Case(cut=cut, seed=seed))
    return found


def refuse_absurd_comparison(cfg: CompareCfg, n_cases: int) -> None:
    """Raise InputError for cuts that would take too long or too much memory."""
    ways = MEASURES if cfg.twin is None else MEASURES + 1
    runs, slowest = ways * n_cases * (cfg.iterations + 1), min(cfg.speeds)
    needs = effort(2.0 * np.pi * RADIUS, slowest * 1e-3, runs, estimated=True)
    refuse_absurd(f"{runs} runs at {slowest:g} mm/s and more", needs)


def starts_of(before: Earlier[CompareCfg], number: int, case: Case) -> dict[str, Start]:
    """Start of each loop of a case, by its number. InputError where it was not cut at this pose."""
    if before.goes_on:
        return dict(_states(before, number))
    # The earlier case at this pose, by preference at this speed and limit.
    cases, cut = cases_of(before.options, before.seed), case.cut
    at = {i: each.cut for i, each in enumerate(cases) if each.cut.pose == cut.pose}
    if not at:
        known = ", ".join(dict.fromkeys(str(each.cut.pose) for each in cases))
        raise InputError(f"{before.run.folder} has no cut at {cut.pose}. It has: {known}")
    same = min(at, key=lambda i: (at[i].speed != cut.speed) + (at[i].limits != cut.limits))
    old, new = (each.experiment().motion for each in (cases[same], case))
    return {name: before.taken(state, old, new) for name, state in _states(before, same).items()}


def _states(before: Earlier[CompareCfg], number: int) -> dict[str, RunState]:
    """By measured output."""
    return {
        name.partition(" ")[2]: state
        for name, state in before.states.items()
        if name.startswith(f"{number} ") and state is not None
    }


def save_states_of(folder: RunFolder, found: Sequence[Mapping[str, Sequence[Iteration]]]) -> None:
    """Write the state of every loop of every case: number of the case, and measured output."""
    states = {
        f"{i} {name}": its[-1].state for i, of in enumerate(found) for name, its in of.items()
    }
    save_states(folder / STATE, {name: state for name, state in states.items() if state})
