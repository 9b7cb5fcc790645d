"""`armside tune`: search the design of the learning law, alone or with other machines."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from armside.sim.laser.design import THESIS
from armside.sim.records.run_folder import RUNS, check_writable
from armside.sim.records.summary import summary
from armside.sim.tuning.action import Motors
from armside.sim.tuning.objective import Objective, prepare
from armside.sim.tuning.situation import RewardSensor

from ..shell.console import Report, run_folder
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import RunFailed, checking_input, needs
from ..shell.interrupts import noticing
from ..shell.options import Common, seed_range
from ..studies import study as studies
from ..studies.options import TuneCfg
from ..studies.search import evaluate, search
from ..studies.storage import redacted, using
from ..studies.tune_report import new_best, results, tables

if TYPE_CHECKING:
    import optuna


OF_A_RUN = Effort(0.1, 5e6)


def tune(*, cfg: TuneCfg = TuneCfg(), common: Common = Common()) -> None:
    """Search gamma, delta and cutoff with Optuna; resume a study or share it with other processes.

    The objective is the tool's RMS after learning over that before, as measured by the sensor of
    --reward, geometric mean of all episodes; its ground truth stands beside it. Writes
    summary.json, history.png and, from ten complete trials on, importance.png.

    Raises InputError for a job, a storage or a folder that cannot be had, RunFailed where no
    design was tried to the end or all of them diverged, and KeyboardInterrupt with what is kept.
    """
    report, cfg, sensor = Report(common), cfg.named(common.seed), RewardSensor(cfg.reward)
    with checking_input():
        with needs("tuning", "armside tune", "Optuna"):
            import optuna  # noqa: F401 - imported again where it is used
        check_writable(common.out or RUNS / "tune")
        seeds = seed_range(common.seed, cfg.episodes)
        _refuse_absurd(cfg)
        episodes = prepare(cfg.rules, seeds, cfg.fixed)
        study = studies.open_study(
            cfg.storage,
            str(cfg.study),
            cfg.identity(common.seed),
            sampler=cfg.sampler,
            pruner=cfg.pruner,
            seed=common.seed,
        )
    with (
        noticing(lambda: _kept(study, cfg)) as stop,
        using(cfg.storage),
        Objective(cfg.rules, episodes, stop.check) as objective,
    ):
        with report.progress("tuning", total=cfg.trials) as step:
            search(
                study,
                partial(evaluate, objective),
                cfg.trials,
                studies.parameters(THESIS, Motors(cfg.motors), objective.rules.n_axes),
                check=stop.check,
                step=step,
                new_best=lambda trial: new_best(report, trial, sensor),
            )
        outcomes, found = studies.outcomes(study), results(study)
        found["notes"] = [*objective.notes, *studies.notes_of_best(study)]
    outcome = summary("tune", replace(cfg, storage=redacted(cfg.storage)), common, **found)
    if not outcome["bests"]:
        n = sum(outcome.complete for outcome in outcomes)
        all_diverged = f"all {n} designs that were tried to the end diverged"
        raise RunFailed(all_diverged if n else "no design was tried to the end")
    with run_folder(outcome, common) as folder:
        from ..figures import tuning as figures

        figures.history(folder / "history.png", outcomes, sensor=sensor.label)
        if outcome["importance"]:
            figures.importance(folder / "importance.png", outcome["importance"])
    report.notes(found["notes"])
    tables(report, outcome, folder.path)
    report.summary(outcome)


def _refuse_absurd(cfg: TuneCfg) -> None:
    runs = cfg.episodes * (cfg.iterations + 1)
    refuse_absurd(f"a trial of {cfg.episodes} episodes", OF_A_RUN * runs)
    refuse_absurd(f"{cfg.trials} trials", Effort(OF_A_RUN.seconds * runs * cfg.trials), kept=True)


def _kept(study: "optuna.Study", cfg: TuneCfg) -> str:
    """The message at the end of a search that was stopped; empty if nothing is kept."""
    kept = len(studies.finished(study))
    if not kept:
        return ""
    where = f"study {cfg.study!r} of {redacted(cfg.storage)!r}"
    return f"interrupted; finished trials kept in {where}: {kept}. Repeat the command to go on"
