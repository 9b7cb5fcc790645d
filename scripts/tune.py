"""`armside tune`: search the design of the learning law, alone or with other machines."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sim.tuning.design import THESIS, Design, Motors
from sim.tuning.rules import Rules
from sim.tuning.situation import Situation, restarted

from . import study as studies
from .console import Report
from .errors import RunFailed, checking_input
from .options import Common, options
from .parallel import cores
from .run_folder import RunFolder
from .summary import dumps, plain, summary

if TYPE_CHECKING:
    import optuna

WORST = 1e3
"""Objective of a design that diverges: no finite one is that bad."""


@options
@dataclass(frozen=True, kw_only=True)
class TuneCfg:
    """What to tune, on which jobs, and how to search."""

    robot: Literal["large", "irb1400"] = "large"
    """Which robot."""
    motors: Literal["shared", "each"] = "shared"
    """One design for all motors, or one for each."""
    reward: Literal["tracker", "motor", "estimate"] = "tracker"
    """Sensor that says how round the cut is."""
    pose: str | None = None
    """Where, by name [default: drawn for each episode]."""
    speed: float | None = None
    """Programmed speed [mm/s] [default: drawn for each episode]."""
    payload: float | None = None
    """Mass of the tool [kg] [default: drawn for each episode]."""
    episodes: int = 4
    """Jobs and robot individuals that a design is tried on, with seeds from --seed on."""
    iterations: int = 5
    """Learning iterations on each."""
    trials: int = 50
    """Trials that the study shall have in the end, those it has already included."""
    sampler: studies.Sampler = "tpe"
    """What proposes designs."""
    pruner: studies.Pruner = "percentile"
    """What gives up on a design between iterations."""
    study: str = "armside"
    """Name of the study; one that exists is resumed."""
    storage: str = "sqlite:///runs/tune.sqlite3"
    """Database of studies: any Optuna storage URL. Processes that share it share the work."""

    def __post_init__(self) -> None:
        for name in ("episodes", "trials"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be >= 1, got {getattr(self, name)}")
        for name, unit in (("speed", "mm/s"), ("payload", "kg")):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be > 0 {unit}, got {value:g}")
        rules(self)


def rules(cfg: TuneCfg) -> Rules:
    """The rules of the episodes. Raises ValueError where the options are out of range."""
    return Rules(robot=cfg.robot, motors=cfg.motors, reward=cfg.reward, iterations=cfg.iterations)


class Objective:
    """Geometric mean, over the episodes, of the tool's RMS after learning over that before.

    The runs before learning are made once; every design then meets the same noise.
    """

    def __init__(self, cfg: TuneCfg, seed: int) -> None:
        """Raises ValueError where a job cannot be done or a seed is sealed."""
        self.rules = rules(cfg)
        fixed: dict[str, Any] = {}
        if cfg.pose is not None:
            fixed["pose"] = cfg.pose
        if cfg.speed is not None:
            fixed["speed"] = cfg.speed * 1e-3
        if cfg.payload is not None:
            fixed["payload"] = cfg.payload
        tasks = []
        for s in range(seed, seed + cfg.episodes):
            self.rules.check_seed(s)
            tasks.append(self.rules.draw(np.random.default_rng(s), fixed))
        self._pool = ThreadPoolExecutor(min(cores(), cfg.episodes))
        self._first = list(self._pool.map(self.rules.begin, tasks))

    def __call__(self, trial: "optuna.Trial") -> float:
        """Try a design, and give up where the pruner says so."""
        import optuna

        design = studies.suggest(trial, Motors(self.rules.motors))
        ratio = 1.0
        for k, ratio in enumerate(self.ratios(design), start=1):
            trial.report(ratio, k)
            if ratio < WORST and k < self.rules.iterations and trial.should_prune():
                raise optuna.TrialPruned
        return ratio

    def ratios(self, design: Design) -> Iterator[float]:
        """The geometric mean after each iteration; WORST, and the last, once any diverged."""
        situations = [restarted(situation) for situation in self._first]
        for _ in range(self.rules.iterations):
            advance = [self._pool.submit(self.rules.advance, s, design) for s in situations]
            situations = [future.result() for future in advance]
            yield self._ratio(situations)
            if any(s.diverged for s in situations):
                return

    def _ratio(self, situations: list[Situation]) -> float:
        if any(s.diverged for s in situations):
            return WORST
        pairs = zip(situations, self._first, strict=True)
        ratio = float(np.exp(np.mean([np.log(s.seen.rms / f.seen.rms) for s, f in pairs])))
        return ratio if np.isfinite(ratio) else WORST

    def close(self) -> None:
        """Stop the threads."""
        self._pool.shutdown()


def tune(*, cfg: TuneCfg = TuneCfg(), common: Common = Common()) -> None:
    """Search gamma, delta and cutoff with Optuna; resume a study or share it with other processes.

    The objective is the tool's RMS after learning as a part of that before, the geometric mean of
    all episodes. Writes summary.json, history.png and importance.png.
    """
    report = Report(common)
    with checking_input():
        objective = Objective(cfg, common.seed)
        study = studies.open_study(
            cfg.storage,
            cfg.study,
            _identity(cfg, common.seed),
            sampler=cfg.sampler,
            pruner=cfg.pruner,
            seed=common.seed,
        )
    try:
        _search(study, objective, cfg, report)
    finally:
        objective.close()
    outcome = summary("tune", cfg, common, **results(study))
    if not outcome["bests"]:
        raise RunFailed("no design was tried to the end")
    with RunFolder("tune", seed=common.seed, out=common.out) as folder:
        from . import tune_figures

        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
        tune_figures.history(folder / "history.png", studies.values(study))
        tune_figures.importance(folder / "importance.png", outcome["importance"])
    _print(report, outcome, folder.path)


def _identity(cfg: TuneCfg, seed: int) -> dict[str, Any]:
    """What makes two studies comparable: all of the task, nothing of the search."""
    search = ("trials", "sampler", "pruner", "study", "storage")
    return {key: v for key, v in plain(cfg).items() if key not in search} | {"seed": seed}


def _search(study: "optuna.Study", objective: Objective, cfg: TuneCfg, report: Report) -> None:
    """Try designs until the study has as many trials as asked for; the thesis's design first."""
    from optuna.study import MaxTrialsCallback
    from optuna.trial import TrialState

    states = (TrialState.COMPLETE, TrialState.PRUNED)
    done = len(studies.finished(study))
    study.enqueue_trial(studies.parameters(THESIS, Motors(cfg.motors)), skip_if_exists=True)
    with report.progress("tuning", total=cfg.trials) as step:
        for _ in range(min(done, cfg.trials)):
            step()

        def show(study: "optuna.Study", trial: "optuna.trial.FrozenTrial") -> None:
            step()
            if trial.state is TrialState.COMPLETE and study.best_trial.number == trial.number:
                report.line(f"best so far, trial {trial.number}: {_row_text(trial)}")

        if done < cfg.trials:
            stop = MaxTrialsCallback(cfg.trials, states=states)
            study.optimize(objective, callbacks=[show, stop])


def results(study: "optuna.Study") -> dict[str, Any]:
    """What a study knows, as summary.json has it."""
    from optuna.trial import TrialState

    trials = study.get_trials(deepcopy=False)
    bests = [{"trial": t.number, "ratio": t.value, **t.params} for t in studies.bests(study)]
    return {
        "trials": {
            state.name.lower(): sum(t.state is state for t in trials) for state in TrialState
        },
        "bests": bests,
        "best": bests[-1] if bests else None,
        "importance": studies.importance(study),
    }


def _row_text(trial: "optuna.trial.FrozenTrial") -> str:
    values = ", ".join(f"{name} {value:.4g}" for name, value in trial.params.items())
    return f"RMS {trial.value:.3f} of that before learning with {values}"


def _print(report: Report, outcome: dict[str, Any], path: Any) -> None:
    names = list(outcome["bests"][-1])
    names = [name for name in names if name not in ("trial", "ratio")]
    report.table(
        "Best so far: RMS of the tool after learning over that before",
        ["trial", "RMS ratio", *names],
        [[b["trial"], b["ratio"], *(b[name] for name in names)] for b in outcome["bests"]],
    )
    report.table(
        "Importance of each parameter",
        ["parameter", "share"],
        [[name, share] for name, share in outcome["importance"].items()],
    )
    counts = ", ".join(f"{n} {state}" for state, n in outcome["trials"].items() if n)
    report.line(f"Trials: {counts}. Results in {path}")
    report.summary(outcome)
