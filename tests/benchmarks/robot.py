"""The virtual robot: overhead over bare physics, and the default experiment."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tests.claims._learned import run as run_cut

from armside import assets
from armside.sim.cell import CELLS
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.robot.run import LoadedReference

from ._timing import Row, bare_rollout, interleaved


def measured() -> Sequence[Row]:
    """A run of each shipped robot against a bare rollout of its steps; then the default experiment.

    The last rows are runs for each step and degree of freedom, against the large robot's.
    """
    names = (*CELLS, *(str(file) for file in shipped_files()))
    loaded = {name: prepare(Cut(robot=name)).loaded for name in names}
    runs = [_run_and_rollout(one) for one in loaded.values()]
    times = interleaved([function for pair in runs for function in pair])
    found = dict(zip(loaded, zip(times[::2], times[1::2], strict=True), strict=True))
    (whole,) = interleaved([lambda: run_cut(Cut())], repeats=5)
    each = {name: found[name][0] / _freedom(one) for name, one in loaded.items()}
    large, *others = each
    return [
        *(
            Row(f"run of {_shown(name, loaded[name])}", *(run, "bare mujoco.rollout", rollout))
            for name, (run, rollout) in found.items()
        ),
        Row("default experiment: six runs, all included", whole),
        *(
            Row(f"{Path(name).stem}, a step and degree of freedom", each[name], large, each[large])
            for name in others
        ),
    ]


def shipped_files() -> list[Path]:
    """Robot files of `armside.assets` that are not those of a named robot."""
    named = {cell.xml for cell in CELLS.values()}
    files = sorted(assets.LARGE_ROBOT_XML.parent.glob("*.toml"))
    return [file for file in files if file.with_suffix(".xml") not in named]


def _run_and_rollout(loaded: LoadedReference) -> tuple[Callable[[], Any], Callable[[], None]]:
    correction, rng = np.zeros_like(loaded.reference), np.random.default_rng(0)
    return lambda: loaded.run(correction, rng), bare_rollout(loaded)


def _freedom(loaded: LoadedReference) -> int:
    """Physics steps of a run times degrees of freedom."""
    return len(loaded.controls) * int(loaded.model.mj.nv)


def _shown(name: str, loaded: LoadedReference) -> str:
    model = loaded.model
    return f"{Path(name).stem}: {model.n_axes} axes, {model.mj.nv} degrees of freedom"
