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
    rows, kerf, iso = outcome["iterations"], outcome["kerf"], outcome["iso"]
    axes = range(1, 1 + len(rows[0]["motor_inf"]))
    columns = ["k", *(f"motor {i}" for i in axes), "arm RMS", "arm max"]
    for title, suffix, mrad, microns in (
        ("Raw: largest motor error [mrad of the motor shaft], tool deviation [µm]", "", 1e3, 1e6),
        ("Normalised by the largest at k = 0: thesis (9.5), (9.8), (9.9)", "_normalised", 1, 1),
    ):
        motor, tool = f"motor_inf{suffix}", (f"arm_rms{suffix}", f"arm_maxdev{suffix}")
        cells = [
            [row["k"], *_times(mrad, row[motor]), *_times(microns, [row[name] for name in tool])]
            for row in rows
        ]
        report.table(title, columns, cells)
    edges = kerf["hole_roundness_true"], kerf["widest_true"]
    config = outcome["config"]
    round_hole = config["shape"] == "circle" and config["contour"] is None
    edge = "hole roundness" if round_hole else "band of the edge"
    accuracy = iso["path_accuracy"], iso["path_accuracy_in_plane"]
    report.table(
        f"Cut edge with a beam of {1e3 * kerf['beam']:g} mm, and path accuracy as ISO 9283 [µm]",
        ["k", edge, "widest kerf", "AT_p", "AT_p in the plane"],
        [
            [row["k"], *_times(1e6, values)]
            for row, *values in zip(rows, *edges, *accuracy, strict=True)
        ],
    )
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
