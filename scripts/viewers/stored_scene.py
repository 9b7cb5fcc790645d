"""From a laser run on disk to what its replay shows."""

from armside.sim.records.stored_run import StoredRun
from armside.sim.replay.scene import Scene

from ..commands import laser
from ..shell.errors import InputError, checking_input
from .replay_scene import scene


def stored_scene(run: StoredRun, *, name: str = "") -> Scene:
    """What is shown of a laser run on disk.

    Raises:
        InputError: another experiment, or options that this version does not know.
    """
    if run.experiment != "laser":
        raise InputError(
            f"{run.path} is a run of {run.experiment}; only those of laser are redrawn"
        )
    with checking_input():
        cfg = run.configuration(laser.LaserCfg)
        experiment = laser.prepare(cfg, run.summary["config"]["seed"])
    mj = experiment.loaded.model.mj
    return scene(run.summary, mj, run.signals.runs, experiment.motion, name=name)
