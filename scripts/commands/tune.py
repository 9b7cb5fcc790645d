"""`armside tune`: search the design of the learning law, alone or with other machines."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from armside.sim.laser.design import THESIS
from armside.sim.records.run_folder import RUNS, RunFolder, check_writable
from armside.sim.records.summary import dumps, plain, summary
from armside.sim.tuning.action import Motors
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.sensor import Sees
from armside.sim.tuning.task import FASTEST, SLOWEST

from ..shell.console import Report
from ..shell.errors import RunFailed, checking_input
from ..shell.interrupts import Stop, noticing
from ..shell.options import Common, options
from ..studies import study as studies
from ..studies.importance import importance
from ..studies.objective import Objective, prepare
from ..studies.report import new_best, tables
from ..studies.storage import redacted, using
from ..studies.study import Tried

if TYPE_CHECKING:
    import optuna


@options
@dataclass(frozen=True, kw_only=True)
class TuneCfg:
    """What to tune, on which jobs, and how to search."""

    robot: Literal["large", "irb1400"] = "large"
    """Which robot."""
    motors: Literal["shared", "each"] = "shared"
    """One design for all motors, or one for each."""
    reward: Literal["tracker", "motor", "estimate"] = "tracker"
    """Sensor that says how round the cut is, and is believed."""
    pose: str | None = None
    """Where, by name [default: drawn for each episode]."""
    speed: float | None = None
    """Programmed speed, 1 to 100 [mm/s] [default: drawn for each episode]."""
    payload: float | None = None
    """Mass of the large robot's tool [kg], the IRB1400 keeps its own [default: drawn for each
    episode]."""
    episodes: int = 4
    """Jobs and robot individuals that a design is tried on, with seeds from --seed on."""
    iterations: int = 5
    """Learning iterations on each."""
    trials: int = 50
    """Trials that the study shall have in the end, those it has already included. Processes that
    share it end the trial they are in: it may get one more of each."""
    sampler: studies.Sampler = "tpe"
    """What proposes designs."""
    pruner: studies.Pruner = "percentile"
    """What gives up on a design between iterations."""
    study: str | None = None
    """Name of the study; one that exists is resumed [default: named after what is tuned]."""
    storage: str = "sqlite:///runs/tune.sqlite3"
    """Database of studies, as an SQLAlchemy URL. Processes that share it share the work."""

    def __post_init__(self) -> None:
        for name in ("episodes", "trials"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be >= 1, got {getattr(self, name)}")
        slowest, fastest = 1e3 * SLOWEST, 1e3 * FASTEST
        if self.speed is not None and not slowest <= self.speed <= fastest:
            raise ValueError(
                f"speed must be from {slowest:g} to {fastest:g} mm/s, got {self.speed:g}"
            )
        if self.payload is not None and not 0.0 <= self.payload < float("inf"):
            raise ValueError(f"payload must be >= 0 kg, got {self.payload:g}")
        if self.study is not None and not self.study.strip():
            raise ValueError(f"study must have a name, got {self.study!r}")
        rules(self)


def rules(cfg: TuneCfg) -> Rules:
    """The rules of the episodes. Raises ValueError where the options are out of range."""
    return Rules(robot=cfg.robot, motors=cfg.motors, reward=cfg.reward, iterations=cfg.iterations)


def tune(*, cfg: TuneCfg = TuneCfg(), common: Common = Common()) -> None:
    """Search gamma, delta and cutoff with Optuna; resume a study or share it with other processes.

    The objective is the tool's RMS after learning as a part of that before, as --reward sees it,
    the geometric mean of all episodes; the same in truth stands beside it. Writes summary.json,
    history.png and, from ten complete trials on, importance.png.

    Raises InputError for a job, a storage or a folder that cannot be had, RunFailed where no
    design was tried to the end or all of them diverged, and KeyboardInterrupt with what is kept.
    """
    report = Report(common)
    cfg = replace(cfg, study=cfg.study or study_name(cfg, common.seed))
    with checking_input():
        check_writable(common.out or RUNS / "tune")
        seeds = range(common.seed, common.seed + cfg.episodes)
        episodes = prepare(rules(cfg), seeds, _fixed(cfg))
        study = studies.open_study(
            cfg.storage,
            str(cfg.study),
            _identity(cfg, common.seed),
            sampler=cfg.sampler,
            pruner=cfg.pruner,
            seed=common.seed,
        )
    with (
        noticing(lambda: _kept(study, cfg)) as stop,
        using(cfg.storage),
        Objective(rules(cfg), episodes, stop) as objective,
    ):
        _search(study, objective, cfg, report, stop)
        tried, found = studies.outcomes(study), results(study)
    shown = replace(cfg, storage=redacted(cfg.storage))
    outcome = summary("tune", shown, common, **found)
    if not outcome["bests"]:
        raise RunFailed(_without_result(tried))
    with RunFolder("tune", seed=common.seed, out=common.out) as folder:
        from ..figures import tuning as tune_figures

        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
        tune_figures.history(folder / "history.png", tried, sees=Sees(cfg.reward).says)
        if outcome["importance"]:
            tune_figures.importance(folder / "importance.png", outcome["importance"])
    tables(report, outcome, folder.path)
    report.summary(outcome)


def _fixed(cfg: TuneCfg) -> dict[str, Any]:
    """What is not drawn for each episode, as the env has it."""
    speed = None if cfg.speed is None else cfg.speed * 1e-3
    given = {"pose": cfg.pose, "speed": speed, "payload": cfg.payload}
    return {name: value for name, value in given.items() if value is not None}


def study_name(cfg: TuneCfg, seed: int) -> str:
    """A name of what is tuned: the same for studies that can be compared, and for no others."""
    text = json.dumps(_identity(cfg, seed), sort_keys=True)
    key = hashlib.sha256(text.encode()).hexdigest()[:8]
    return f"{cfg.robot}-{cfg.motors}-{cfg.reward}-{key}"


def _identity(cfg: TuneCfg, seed: int) -> dict[str, Any]:
    """What makes two studies comparable: all of the task, nothing of the search."""
    search = ("trials", "sampler", "pruner", "study", "storage")
    return {key: v for key, v in plain(cfg).items() if key not in search} | {"seed": seed}


def _search(
    study: "optuna.Study", objective: Objective, cfg: TuneCfg, report: Report, stop: Stop
) -> None:
    """Try designs until the study has as many trials as asked for; the thesis's design first.

    What other processes add to the study is told too, when a trial of this one ends.
    """
    done, sees = 0, Sees(cfg.reward)
    best = min((t.seen for t in studies.outcomes(study) if t.whole), default=studies.WORST)
    if len(studies.finished(study)) < cfg.trials:
        thesis = studies.parameters(THESIS, Motors(cfg.motors))
        studies.ask_first(study, thesis, stop.check)
    with report.progress("tuning", total=cfg.trials) as step:
        while True:
            known = min(len(studies.finished(study)), cfg.trials)
            for _ in range(known - done):
                step()
            done = known
            for trial in studies.bests(study):
                if studies.value(trial) < best:
                    best = studies.value(trial)
                    new_best(report, trial, sees)
            if done >= cfg.trials:
                return
            _try_one(study, objective)
            stop.check()


def _try_one(study: "optuna.Study", objective: Objective) -> None:
    """One more trial. One that others have taken for dead, as after a machine has slept, is theirs
    to repeat."""
    objective.taken = False
    try:
        study.optimize(objective, n_trials=1)
    except ValueError:  # Optuna cannot end it once more
        if not objective.taken:
            raise


def _kept(study: "optuna.Study", cfg: TuneCfg) -> str:
    """What is left of a search that was stopped; empty if nothing is."""
    kept = len(studies.finished(study))
    if not kept:
        return ""
    where = f"study {cfg.study!r} of {redacted(cfg.storage)!r}"
    return f"interrupted; finished trials kept in {where}: {kept}. Repeat the command to go on"


def _without_result(tried: Sequence[Tried]) -> str:
    whole = sum(t.whole for t in tried)
    if not whole:
        return "no design was tried to the end"
    return f"all {whole} designs that were tried to the end diverged"


def results(study: "optuna.Study") -> dict[str, Any]:
    """What a study knows, as summary.json has it."""
    from optuna.trial import TrialState

    trials = study.get_trials(deepcopy=False)
    bests = [
        {
            "trial": t.number,
            "ratio": t.value,
            studies.TRUE: t.user_attrs.get(studies.TRUE),
            **t.params,
        }
        for t in studies.bests(study)
    ]
    return {
        "trials": {
            state.name.lower(): sum(t.state is state for t in trials) for state in TrialState
        },
        "bests": bests,
        "best": bests[-1] if bests else None,
        "importance": {name: found._asdict() for name, found in importance(study).items()},
    }
