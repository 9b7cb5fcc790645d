"""Files and tables of `armside laser`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.sim.evaluation.kerf import kerf
from armside.sim.laser.experiment import Experiment, Iteration
from armside.sim.motion.contour import Circle
from armside.sim.motion.tool_motion import ToolMotion
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps

from ..shell.console import Report

if TYPE_CHECKING:
    from armside.sim.records.signals import RecordedRun

TRUTH_RATE = 1000.0
"""[Hz], of the ground truth on disk."""


def write(
    folder: RunFolder,
    experiment: Experiment[ToolMotion],
    iterations: list[Iteration],
    outcome: dict[str, Any],
) -> None:
    """Write the files of a run, which together are all that replay and measure need."""
    from armside.sim.records.signals import RecordedRun

    from . import laser as figures

    runs = [
        RecordedRun(k=it.k, recording=it.run.recording, tracker=it.run.tracker) for it in iterations
    ]
    write_run(folder, experiment, runs, outcome, TRUTH_RATE)
    curve, rows = experiment.motion.curve, outcome["iterations"]
    rms, maxdev = ([row[key] for row in rows] for key in ("arm_rms", "arm_maxdev"))
    reference = curve.point(np.linspace(0.0, curve.length, 361))
    paths = [it.tool.path for it in iterations]
    names = [f"k = {it.k}" for it in iterations]
    figures.circles(folder / "circles.png", reference, paths, rms=rms, maxdev=maxdev, names=names)
    # The first cut and the last, as the tool truly made them.
    shown = [iterations[0], iterations[-1]] if len(iterations) > 1 else iterations
    cuts = [(it.k, kerf(curve, it.tool_true.path, outcome["kerf"]["beam"])) for it in shown]
    measure = "roundness" if isinstance(curve, Circle) else "band of the edge"
    figures.kerf(folder / "kerf.png", cuts, measure)


def write_run(
    folder: RunFolder,
    experiment: Experiment,
    runs: "list[RecordedRun]",
    outcome: dict[str, Any],
    truth_rate: float,
) -> None:
    """Write summary, signals, individual, robot, replay and the figure of errors.

    truth_rate: [Hz], of the ground truth on disk.
    """
    from armside.sim.records.signals import write_signals
    from armside.sim.replay.run_scene import laser_scene
    from armside.sim.replay.scene import write_scenes
    from armside.sim.robot.individual import as_built
    from armside.sim.robot.individual_file import individual_toml
    from armside.sim.robot.mjcf import write_robot

    from . import laser as figures

    (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    config, rows, model = outcome["config"], outcome["iterations"], experiment.loaded.model
    write_signals(
        folder / "signals.parquet",
        runs,
        config=config,
        seed=config["seed"],
        truth_rate=truth_rate,
        motion=experiment.motion,
        gear=model.drives.gear,
    )
    own = experiment.individual
    (folder / "individual.toml").write_text(individual_toml(own), encoding="utf-8")
    write_robot(folder / "robot.xml", as_built(experiment.nominal, own).parsed())
    scene = laser_scene(outcome, model.mj, runs, experiment.motion)
    write_scenes(folder / "replay.rrd", [scene])
    keys = "motor_inf_normalised", "arm_rms", "arm_maxdev", "k"
    motor, rms, maxdev, ks = ([row[key] for row in rows] for key in keys)
    label = "motor error, ∞-norm, normalised"
    file = folder / "errors.png"
    figures.errors(file, np.array(motor), rms, maxdev, motor_label=label, ks=ks)


def show(report: Report, outcome: dict[str, Any], path: Path) -> None:
    """Print the result by iteration, in the words and units of README; the rest is on disk."""
    rows, iso = outcome["iterations"], outcome["iso"]
    cells = [
        [
            row["k"],
            *_times(1e3, [None if None in row["motor_inf"] else max(row["motor_inf"])]),
            *_times(1e6, [row["arm_rms"], row["arm_maxdev"]]),
            *_times(100.0, [row["arm_rms_normalised"]]),
        ]
        for row in rows
    ]
    title = "Motor error at the motor shaft; per cent of the tool RMS at k = 0"
    columns = ["k", "worst motor [mrad]", "tool RMS [µm]", "tool maximum [µm]", "% of k = 0"]
    report.table(title, columns, cells)
    if iso["repetitions"]:
        tracked, true = iso["path_repeatability"], iso["path_repeatability_true"]
        of_runs = f"Path repeatability RT_p of {iso['repetitions']} runs"
        report.line(f"{of_runs}: {_microns(tracked)} tracked, {_microns(true)} true")
    if outcome["loop_error"]:
        report.line(f"The linkage opened by {1e6 * outcome['loop_error']:.3f} µm at most")
    report.line(f"Results in {path}")
    report.summary(outcome)


def _times(factor: float, values: Sequence[float | None]) -> list[float | None]:
    return [None if x is None else factor * x for x in values]


def _microns(value: float | None) -> str:
    return "none" if value is None else f"{1e6 * value:.1f} µm"
