"""Results of `armside tune`, with the importance of each parameter, and their printing."""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from armside.sim.tuning.action import VARIABLES
from armside.sim.tuning.situation import RewardSensor

from ..shell.console import Report
from .storage import redacted
from .study import CRITERION, TRUE, bests, parameter_names

if TYPE_CHECKING:
    import optuna

ENOUGH = 10
"""Complete trials, of which the best tenth is one."""
SHUFFLES = 19
"""Random permutations of the objective: one study in twenty exceeds their largest by chance."""


class Importance(NamedTuple):
    """Fraction of the importance of all parameters for being among the best tenth of the trials."""

    share: float
    by_chance: float
    """The largest in random orders of the trials, on the same scale: a fraction that is not above
    it is not significant."""


def importance(study: "optuna.Study") -> dict[str, Importance]:
    """Importance of each parameter by PED-ANOVA over the complete trials, the largest first. A
    design that diverged counts as the worst. Empty while too few trials are complete, or where all
    of them are alike."""
    from optuna.trial import TrialState

    trials = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if len(trials) < ENOUGH:
        return {}
    values = np.array([trial.value for trial in trials], dtype=float)
    rng = np.random.default_rng(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # warns of a void result
        try:
            found = _divergences(trials, values)
            random = [_divergences(trials, rng.permutation(values)) for _ in range(SHUFFLES)]
        except (RuntimeError, ValueError, UserWarning):
            return {}
    total = sum(found.values())
    if not total > 0.0:
        return {}
    return {
        name: Importance(value / total, max(other[name] for other in random) / total)
        for name, value in sorted(found.items(), key=lambda item: -item[1])
    }


def _divergences(
    trials: "Sequence[optuna.trial.FrozenTrial]", values: np.ndarray
) -> dict[str, float]:
    """Divergence of each parameter's best tenth from all, if the trials had these values."""
    import optuna

    study = optuna.create_study()
    study.add_trials(
        optuna.trial.create_trial(params=t.params, distributions=t.distributions, value=value)
        for t, value in zip(trials, values.tolist(), strict=True)
    )
    return optuna.importance.PedAnovaImportanceEvaluator().evaluate(study)


def results(study: "optuna.Study") -> dict[str, Any]:
    """Trials, best designs and importances of a study, as summary.json has them."""
    from optuna.trial import TrialState

    trials = study.get_trials(deepcopy=False)
    refused = [t.user_attrs.get(CRITERION, 0.0) >= 1.0 for t in trials]
    states = [t.state for t, no in zip(trials, refused, strict=True) if not no]
    counts = {state.name.lower(): states.count(state) for state in TrialState}
    best = [
        {"trial": t.number, "ratio": t.value}
        | {name: t.user_attrs.get(name) for name in (TRUE, CRITERION)}
        | t.params
        for t in bests(study)
    ]
    return {
        "trials": counts | {"refused": sum(refused)},
        "bests": best,
        "best": best[-1] if best else None,
        "importance": {name: found._asdict() for name, found in importance(study).items()},
    }


def new_best(report: Report, trial: "optuna.trial.FrozenTrial", sensor: RewardSensor) -> None:
    """Print a best design, in lines that a terminal of 60 columns holds; not those of every motor,
    which are printed at the end."""
    report.line(f"best so far, trial {trial.number}: ratio {trial.value:.3f} {sensor.label}")
    searched = [n for n, values in trial.distributions.items() if not values.single()]
    known = [(v, trial.params[v.name]) for v in VARIABLES if v.name in searched]
    values = [f"{v.name} {value:.3g} {v.unit}".rstrip() for v, value in known]
    report.line(", ".join([f"true {trial.user_attrs[TRUE]:.3f}", *values]))


def tables(report: Report, outcome: dict[str, Any], path: Path) -> None:
    """Print the designs and importances in the summary of a search; path: folder of its results."""
    config, bests = outcome["config"], outcome["bests"]
    shared = all(v.name in outcome["best"] for v in VARIABLES)
    of_motors = config["measure"] == "motor"
    variables = [v for v in VARIABLES if of_motors or v.name != "delta"]
    # The unit on a line of its own: so the widest table fits in 60 columns.
    heads = [f"{v.name}\n[{v.unit}]" if v.unit else v.name for v in variables]
    source = "" if of_motors else f" from the {config['measure']}"
    title = f"RMS of the tool after learning{source} over that before"
    names = [v.name for v in variables] if shared else []
    report.table(
        f"{title}, {RewardSensor(config['reward']).label}",
        ["trial", "measured", "true", "criterion", *heads[: len(names)]],
        [[best[name] for name in ("trial", "ratio", TRUE, CRITERION, *names)] for best in bests],
    )
    if not shared:
        n_axes = sum(name.startswith(f"{VARIABLES[0].name}_") for name in outcome["best"])
        columns = [[outcome["best"][n] for n in parameter_names(v.name, n_axes)] for v in VARIABLES]
        report.table(
            f"Best design, of trial {outcome['best']['trial']}",
            ["motor", *heads],
            list(zip(range(1, n_axes + 1), *columns, strict=True)),
        )
    if found := outcome["importance"]:
        absent = () if of_motors else ("delta",)
        rows = [[n, i["share"], i["by_chance"]] for n, i in found.items() if n not in absent]
        columns = ["parameter", "fraction", "most by chance"]
        report.table("Importance of each parameter (PED-ANOVA)", columns, rows)
    if (found := outcome.get("gain")) is not None:
        at = f"at {found['runs']} runs, on {found['episodes']} other jobs: {found['ratio']:.3f}"
        interval = f"(95 % interval {found['low']:.3f} to {found['high']:.3f})"
        report.line(f"RMS over that of random search {at} {interval}")
    counts = ", ".join(f"{n} {state}" for state, n in outcome["trials"].items() if n)
    where = f"study {config['study']!r} of {redacted(config['storage'])!r}"
    report.line(f"Trials: {counts}, in {where}. Results in {path}")
