"""Files and tables of `armside laser`."""

from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.cut.contour import Circle
from armside.sim.evaluation.kerf import kerf
from armside.sim.laser.experiment import Experiment, Iteration
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps

from ..shell.console import Report


def write(
    folder: RunFolder, experiment: Experiment, iterations: list[Iteration], outcome: dict[str, Any]
) -> None:
    """Write the files of a run, which together are all that replay and measure need."""
    from armside.sim.records.robot_file import write_robot
    from armside.sim.records.signals import RecordedRun, write_signals
    from armside.sim.replay.run_scene import laser_scene
    from armside.sim.replay.scene import write_scenes

    from . import laser as figures

    (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    runs = [
        RecordedRun(k=it.k, recording=it.run.recording, tracker=it.run.tracker) for it in iterations
    ]
    config = outcome["config"]
    motion, model = experiment.motion, experiment.loaded.model
    write_signals(
        folder / "signals.parquet",
        runs,
        config=config,
        seed=config["seed"],
        motion=motion,
        gear=model.drives.gear,
    )
    write_robot(folder / "robot.xml", experiment.nominal.parsed())
    write_scenes(folder / "replay.rrd", [laser_scene(outcome, model.mj, runs, motion)])
    rows = outcome["iterations"]
    curve = experiment.cut.curve
    figures.circles(
        folder / "circles.png",
        curve.point(np.linspace(0.0, curve.length, 361)),
        [it.tool.path for it in iterations],
        rms=[row["arm_rms"] for row in rows],
        maxdev=[row["arm_maxdev"] for row in rows],
    )
    figures.errors(
        folder / "errors.png",
        np.array([row["motor_inf_normalised"] for row in rows]),
        [row["arm_rms"] for row in rows],
        [row["arm_maxdev"] for row in rows],
        motor_label="motor error, ∞-norm, normalised",
    )
    _draw_kerf(folder / "kerf.png", experiment, iterations, outcome["kerf"])


def _draw_kerf(
    file: Path, experiment: Experiment, iterations: list[Iteration], measures: dict[str, Any]
) -> None:
    """The first cut and the last, as the tool truly made them."""
    from . import kerf as kerf_figure

    beam, curve = measures["beam"], experiment.cut.curve
    shown = [iterations[0], iterations[-1]] if len(iterations) > 1 else iterations
    cuts = [(it.k, kerf(curve, it.tool_true.path, beam)) for it in shown]
    kerf_figure.kerf(
        file,
        curve.point(cuts[0][1].arc_length),
        cuts[0][1].arc_length,
        [
            kerf_figure.CutEdges(
                k=k,
                outer=cut.edge(cut.outer),
                inner=cut.edge(cut.inner),
                deviation=cut.hole_deviation,
                roundness=cut.roundness,
            )
            for k, cut in cuts
        ],
        beam=beam,
        measure="roundness" if isinstance(curve, Circle) else "band of the edge",
    )


def show(report: Report, outcome: dict[str, Any], path: Path) -> None:
    motors = [f"motor {i}" for i in range(1, 7)]
    rows = outcome["iterations"]
    report.table(
        "Raw: largest motor error [mrad of the motor shaft], tool deviation [µm]",
        ["k", *motors, "arm RMS", "arm max"],
        [
            [
                row["k"],
                *(1e3 * x for x in row["motor_inf"]),
                1e6 * row["arm_rms"],
                1e6 * row["arm_maxdev"],
            ]
            for row in rows
        ],
    )
    report.table(
        "Normalised by the largest at k = 0: thesis (9.5), (9.8), (9.9)",
        ["k", *motors, "arm RMS", "arm max"],
        [
            [
                row["k"],
                *row["motor_inf_normalised"],
                row["arm_rms_normalised"],
                row["arm_maxdev_normalised"],
            ]
            for row in rows
        ],
    )
    kerf, iso = outcome["kerf"], outcome["iso"]
    report.table(
        f"Cut edge with a beam of {1e3 * kerf['beam']:g} mm, and path accuracy as ISO 9283 [µm]",
        ["k", "hole roundness", "widest kerf", "AT_p", "AT_p in the plane"],
        [
            [row["k"], *(None if x is None else 1e6 * x for x in values)]
            for row, *values in zip(
                rows,
                kerf["hole_roundness_true"],
                kerf["widest_true"],
                iso["path_accuracy"],
                iso["path_accuracy_in_plane"],
                strict=True,
            )
        ],
    )
    if iso["repetitions"]:
        report.line(
            f"Path repeatability RT_p of {iso['repetitions']} runs: "
            f"{_microns(iso['path_repeatability'])} tracked, "
            f"{_microns(iso['path_repeatability_true'])} true"
        )
    if outcome["loop_error"]:
        report.line(f"The linkage opened by {1e6 * outcome['loop_error']:.3f} µm at most")
    report.line(f"Results in {path}")
    report.summary(outcome)


def _microns(value: float | None) -> str:
    return "none" if value is None else f"{1e6 * value:.1f} µm"
