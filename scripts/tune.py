"""`armside tune`: search the design of the learning law, alone or with other machines."""

import hashlib
import json
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from sim.tuning.design import THESIS, VARIABLES, Design, Motors
from sim.tuning.rules import Rules
from sim.tuning.situation import Situation, restarted

from . import study as studies
from .console import Report
from .errors import RunFailed, checking_input
from .options import Common, options
from .parallel import cores
from .run_folder import RunFolder
from .study import WORST
from .study_storage import shown
from .summary import dumps, plain, summary

if TYPE_CHECKING:
    import optuna

SEEN = {
    "tracker": "as the tracker sees it",
    "estimate": "as the estimate sees it",
    "motor": "as the motors see it",
}
"""Whose eyes the objective is seen with, by reward."""
UNITS = {
    name: variable.unit
    for variable in VARIABLES
    for name in (variable.name, *studies.parameter_names(variable.name))
}
"""Of each parameter; empty for a gain."""


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
    """Programmed speed [mm/s] [default: drawn for each episode]."""
    payload: float | None = None
    """Mass of the tool [kg] [default: drawn for each episode]."""
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
        for name, unit in (("speed", "mm/s"), ("payload", "kg")):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be > 0 {unit}, got {value:g}")
        rules(self)


def rules(cfg: TuneCfg) -> Rules:
    """The rules of the episodes. Raises ValueError where the options are out of range."""
    return Rules(robot=cfg.robot, motors=cfg.motors, reward=cfg.reward, iterations=cfg.iterations)


class Ratio(NamedTuple):
    """The tool's RMS after learning over that before, as the geometric mean of all episodes."""

    seen: float
    """As the configured sensor sees it; WORST once an episode diverged."""
    true: float
    """As it was."""


class Objective:
    """What a design leaves of the tool's RMS, in the eyes of the configured sensor.

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
        ratio, hopeless = Ratio(1.0, 1.0), False
        for k, ratio in enumerate(self.ratios(design), start=1):
            trial.report(ratio.seen, k)
            going_on = ratio.seen < WORST and k < self.rules.iterations
            hopeless = going_on and trial.should_prune()
            if hopeless:
                break
        trial.set_user_attr(studies.TRUE, ratio.true)
        if hopeless:
            raise optuna.TrialPruned
        return ratio.seen

    def ratios(self, design: Design) -> Iterator[Ratio]:
        """The ratio after each iteration; WORST, and the last, once any episode diverged."""
        situations = [restarted(situation) for situation in self._first]
        for _ in range(self.rules.iterations):
            advance = [self._pool.submit(self.rules.advance, s, design) for s in situations]
            situations = [future.result() for future in advance]
            yield self._ratio(situations)
            if any(s.diverged for s in situations):
                return

    def _ratio(self, situations: list[Situation]) -> Ratio:
        if any(s.diverged for s in situations):
            return Ratio(WORST, WORST)
        pairs = list(zip(situations, self._first, strict=True))
        return Ratio(
            seen=_mean_ratio((s.seen.rms, first.seen.rms) for s, first in pairs),
            true=_mean_ratio((s.true.rms, first.true.rms) for s, first in pairs),
        )

    def close(self) -> None:
        """Stop the threads."""
        self._pool.shutdown()


def _mean_ratio(pairs: Iterable[tuple[float, float]]) -> float:
    """Geometric mean of after over before; WORST where there is none."""
    ratio = float(np.exp(np.mean([np.log(after / before) for after, before in pairs])))
    return ratio if np.isfinite(ratio) else WORST


def tune(*, cfg: TuneCfg = TuneCfg(), common: Common = Common()) -> None:
    """Search gamma, delta and cutoff with Optuna; resume a study or share it with other processes.

    The objective is the tool's RMS after learning as a part of that before, as --reward sees it,
    the geometric mean of all episodes; the same in truth stands beside it. Writes summary.json,
    history.png and, from five complete trials on, importance.png.

    Raises InputError for a job or a storage that cannot be had, and RunFailed where no design was
    tried to the end or all of them diverged.
    """
    report = Report(common)
    cfg = replace(cfg, study=cfg.study or study_name(cfg, common.seed))
    with checking_input():
        objective = Objective(cfg, common.seed)
        study = studies.open_study(
            cfg.storage,
            str(cfg.study),
            _identity(cfg, common.seed),
            sampler=cfg.sampler,
            pruner=cfg.pruner,
            seed=common.seed,
        )
    try:
        _search(study, objective, cfg, report)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(_interrupted(study, cfg)) from None
    finally:
        objective.close()
    outcome = summary("tune", cfg, common, **results(study))
    if not outcome["bests"]:
        raise RunFailed(_without_result(study))
    with RunFolder("tune", seed=common.seed, out=common.out) as folder:
        from . import tune_figures

        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
        tried = studies.outcomes(study)
        tune_figures.history(folder / "history.png", tried, sees=SEEN[cfg.reward])
        if outcome["importance"]:
            tune_figures.importance(folder / "importance.png", outcome["importance"])
    _print(report, outcome, folder.path)


def study_name(cfg: TuneCfg, seed: int) -> str:
    """A name of what is tuned: the same for studies that can be compared, and for no others."""
    text = json.dumps(_identity(cfg, seed), sort_keys=True)
    key = hashlib.sha256(text.encode()).hexdigest()[:8]
    return f"{cfg.robot}-{cfg.motors}-{cfg.reward}-{key}"


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
    if done < cfg.trials:
        studies.ask_first(study, studies.parameters(THESIS, Motors(cfg.motors)))
    with report.progress("tuning", total=cfg.trials) as step:
        for _ in range(min(done, cfg.trials)):
            step()

        def show(study: "optuna.Study", trial: "optuna.trial.FrozenTrial") -> None:
            step()
            bests = studies.bests(study)
            if bests and bests[-1].number == trial.number:
                report.line(f"best so far, trial {trial.number}: {_row_text(trial, cfg)}")

        if done < cfg.trials:
            stop = MaxTrialsCallback(cfg.trials, states=states)
            study.optimize(objective, callbacks=[show, stop])


def _interrupted(study: "optuna.Study", cfg: TuneCfg) -> str:
    """What is left of a search that was stopped; empty if nothing is."""
    kept = len(studies.finished(study))
    if not kept:
        return ""
    where = f"study {cfg.study!r} of {shown(cfg.storage)}"
    return f"interrupted; finished trials kept in {where}: {kept}. Repeat the command to go on"


def _without_result(study: "optuna.Study") -> str:
    whole = sum(tried.whole for tried in studies.outcomes(study))
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
        "importance": studies.importance(study),
    }


def _row_text(trial: "optuna.trial.FrozenTrial", cfg: TuneCfg) -> str:
    values = ", ".join(f"{k} {v:.4g} {UNITS[k]}".rstrip() for k, v in trial.params.items())
    seen = f"{trial.value:.3f} of that before learning {SEEN[cfg.reward]}"
    return f"RMS {seen}, {trial.user_attrs[studies.TRUE]:.3f} in truth, with {values}"


def _print(report: Report, outcome: dict[str, Any], path: Path) -> None:
    config = outcome["config"]
    names = [name for name in outcome["best"] if name in UNITS]
    heads = [f"{name} [{UNITS[name]}]" if UNITS[name] else name for name in names]
    report.table(
        "Best so far: RMS of the tool after learning over that before",
        ["trial", SEEN[config["reward"]], "in truth", *heads],
        [
            [b["trial"], b["ratio"], b[studies.TRUE], *(b[name] for name in names)]
            for b in outcome["bests"]
        ],
    )
    if outcome["importance"]:
        report.table(
            "Importance of each parameter (PED-ANOVA)",
            ["parameter", "share"],
            [[name, share] for name, share in outcome["importance"].items()],
        )
    counts = ", ".join(f"{n} {state}" for state, n in outcome["trials"].items() if n)
    where = f"study {config['study']!r} of {shown(config['storage'])}"
    report.line(f"Trials: {counts}, in {where}. Results in {path}")
    report.summary(outcome)
