"""Output of `armside tune`: new best designs while it searches, and tables at its end."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from armside.sim.tuning.action import VARIABLES
from armside.sim.tuning.sensor import RewardSensor

from ..shell.console import Report
from .storage import redacted
from .study import TRUE, parameter_names

if TYPE_CHECKING:
    import optuna


def new_best(report: Report, trial: "optuna.trial.FrozenTrial", sensor: RewardSensor) -> None:
    """Print a best design, in lines that a terminal of 60 columns holds; not those of every motor,
    which are printed at the end."""
    report.line(f"best so far, trial {trial.number}: ratio {trial.value:.3f} {sensor.label}")
    known = [(v, trial.params[v.name]) for v in VARIABLES if v.name in trial.params]
    values = [f"{v.name} {value:.3g} {v.unit}".rstrip() for v, value in known]
    report.line(", ".join([f"true {trial.user_attrs[TRUE]:.3f}", *values]))


def tables(report: Report, outcome: dict[str, Any], path: Path) -> None:
    """Print the designs and importances in the summary of a search; path: folder of its results."""
    config, bests = outcome["config"], outcome["bests"]
    shared = all(v.name in outcome["best"] for v in VARIABLES)
    # The unit on a line of its own: so the widest table fits in 60 columns.
    heads = [f"{v.name}\n[{v.unit}]" if v.unit else v.name for v in VARIABLES]
    title = "RMS of the tool after learning over that before"
    names = [v.name for v in VARIABLES] if shared else []
    report.table(
        f"{title}, {RewardSensor(config['reward']).label}",
        ["trial", "measured", "true", *heads[: len(names)]],
        [[best[name] for name in ("trial", "ratio", TRUE, *names)] for best in bests],
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
        rows = [[name, i["share"], i["by_chance"]] for name, i in found.items()]
        columns = ["parameter", "fraction", "most by chance"]
        report.table("Importance of each parameter (PED-ANOVA)", columns, rows)
    counts = ", ".join(f"{n} {state}" for state, n in outcome["trials"].items() if n)
    where = f"study {config['study']!r} of {redacted(config['storage'])!r}"
    report.line(f"Trials: {counts}, in {where}. Results in {path}")
