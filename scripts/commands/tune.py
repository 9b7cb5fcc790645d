"""`armside tune`: search the design of the learning law, alone or with other machines."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.design import THESIS, Design
from armside.sim.laser.tool_measure import Source
from armside.sim.records.run_folder import RUNS, check_writable
from armside.sim.records.summary import summary
from armside.sim.robot.individual import Individual
from armside.sim.tuning.action import Motors
from armside.sim.tuning.objective import Objective, prepare
from armside.sim.tuning.rules import HORIZON
from armside.sim.tuning.situation import RewardSensor
from armside.sim.tuning.tool_objective import DEFAULT, ToolObjective, tool_path

from ..shell.console import Report, run_folder
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import RunFailed, checking_input, needs
from ..shell.interrupts import noticing
from ..shell.options import Common, seed_range
from ..studies import study as studies
from ..studies.options import TuneCfg
from ..studies.search import against_random, evaluate, nominal_best, search
from ..studies.storage import redacted, using
from ..studies.tune_report import new_best, results, tables

if TYPE_CHECKING:
    import optuna


Check = Callable[[], None]
OF_A_RUN = Effort(0.1, 5e6)
OTHERS = 12
"""Jobs that two designs are compared on, with the seeds after those of the search."""


def tune(*, cfg: TuneCfg = TuneCfg(), common: Common = Common()) -> None:
    """Search gamma, delta and cutoff with Optuna; resume a study or share it with other processes.

    The objective is the tool's RMS after learning over that before, as measured by the sensor of
    --reward, geometric mean of all episodes; its ground truth stands beside it. A design is also
    held up to update 20, by the model of the motors, and the worse of both runs counts; one whose
    criterion is 1 or more is refused without a run. Writes summary.json, history.png and, from ten
    complete trials on, importance.png.

    Raises InputError for a job, a storage or a folder that cannot be had, RunFailed where no
    design was tried to the end or all of them diverged, and KeyboardInterrupt with what is kept.
    """
    report, cfg, sensor = Report(common), cfg.named(common.seed), RewardSensor(cfg.reward)
    with checking_input():
        with needs("tuning", "armside tune", "Optuna"):
            import optuna  # noqa: F401 - imported again where it is used
        check_writable(common.out or RUNS / "tune")
        seeds = seed_range(common.seed, cfg.episodes + (0 if cfg.alone else OTHERS))
        _refuse_absurd(cfg)
        rules = cfg.rules
        objective_of, imu = Objective, None
        if cfg.measure != "motor":  # which needs a unit at the tool
            objective_of, imu = partial(ToolObjective, source=Source(cfg.measure)), ImuCfg()
        jobs = prepare(rules, seeds, cfg.fixed, imu)
        if cfg.measure != "motor":
            tool_path(Source(cfg.measure)).assumed(jobs[0].experiment)
        episodes, others = jobs[: cfg.episodes], jobs[cfg.episodes :]
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
        objective_of(rules, episodes, stop.check) as objective,
    ):
        known = THESIS if cfg.measure == "motor" else DEFAULT
        first = [*_from_nominal(cfg, common.seed, report, stop.check), known]
        motors, n_axes = Motors(cfg.motors), rules.n_axes
        with report.progress("tuning", total=cfg.trials) as step:
            search(
                study,
                partial(evaluate, objective),
                cfg.trials,
                [studies.parameters(design, motors, n_axes) for design in first],
                check=stop.check,
                step=step,
                new_best=lambda trial: new_best(report, trial, sensor),
            )
        outcomes, found = studies.outcomes(study), results(study)
        found["notes"] = [*objective.notes, *studies.notes_of_best(study)]
        if others and found["best"]:
            held = 1 if cfg.measure == "motor" else HORIZON - cfg.iterations
            runs = studies.runs(study, cfg.episodes, cfg.iterations, held)
            report.line(f"random search with as many runs, {runs}, and {OTHERS} other jobs ...")
            with objective_of(rules, others, stop.check) as judge:
                found["gain"] = against_random(objective, judge, found["best"], runs, common.seed)
    outcome = summary("tune", replace(cfg, storage=redacted(cfg.storage)), common, **found)
    if not outcome["bests"]:
        n = sum(outcome.complete for outcome in outcomes)
        all_diverged = f"all {n} designs diverged, on the robot or by criterion"
        raise RunFailed(all_diverged if n else "no design was tried to the end")
    with run_folder(outcome, common) as folder:
        from ..figures import tuning as figures

        figures.history(folder / "history.png", outcomes, sensor=sensor.label)
        if outcome["importance"]:
            figures.importance(folder / "importance.png", outcome["importance"])
    report.notes(found["notes"])
    tables(report, outcome, folder.path)
    report.summary(outcome)


def _from_nominal(cfg: TuneCfg, seed: int, report: Report, check: Check) -> list[Design]:
    """Designs that are best on the nominal robot, at the jobs of the search."""
    if not cfg.nominal:
        return []
    fixed = cfg.fixed | {"individual": Individual()}
    jobs = prepare(cfg.rules, seed_range(seed, cfg.episodes), fixed)
    with (
        Objective(cfg.rules, jobs, check) as nominal,
        report.progress("nominal robot", total=cfg.nominal) as step,
    ):
        return nominal_best(nominal, cfg.nominal, seed, step)


def _refuse_absurd(cfg: TuneCfg) -> None:
    held = 2 if cfg.measure == "motor" else HORIZON - cfg.iterations
    runs = cfg.episodes * (cfg.iterations + held) * (2 - cfg.alone)
    refuse_absurd(f"{cfg.nominal} nominal designs", Effort(OF_A_RUN.seconds * runs * cfg.nominal))
    refuse_absurd(f"a trial of {cfg.episodes} episodes", OF_A_RUN * runs)
    refuse_absurd(f"{cfg.trials} trials", Effort(OF_A_RUN.seconds * runs * cfg.trials), kept=True)


def _kept(study: "optuna.Study", cfg: TuneCfg) -> str:
    """The message at the end of a search that was stopped; empty if nothing is kept."""
    kept = len(studies.finished(study))
    if not kept:
        return ""
    where = f"study {cfg.study!r} of {redacted(cfg.storage)!r}"
    return f"interrupted; finished trials kept in {where}: {kept}. Repeat the command to go on"
