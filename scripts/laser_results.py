"""What `armside laser` leaves behind: its summary, its files and its tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures
from armside.sim.cell import CELLS
from armside.sim.cut.path import Circle
from armside.sim.evaluation.kerf import kerf
from armside.sim.evaluation.path_accuracy import path_measures
from armside.sim.laser.experiment import Experiment, Iteration
from armside.sim.laser.plant import Pass
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps
from armside.sim.robot.linkage import checked_loop_error

from .shell.console import Report


def results(experiment: Experiment, iterations: list[Iteration]) -> dict[str, Any]:
    """Status, limits and measures of a run, as `summary.json` has them.

    Raises RuntimeError for a closed chain that did not stay closed.
    """
    rows = [
        {
            "k": it.trial.k,
            "motor_inf": measures.inf_norm(it.motor_error),
            "motor_two": measures.two_norm(it.motor_error),
            "arm_rms": it.arm.rms,
            "arm_maxdev": it.arm.maxdev,
            "arm_rms_true": it.arm_true.rms,
            "arm_maxdev_true": it.arm_true.maxdev,
        }
        for it in iterations
    ]
    for row in rows:
        for name in ("motor_inf", "motor_two", "arm_rms", "arm_maxdev"):
            row[f"{name}_normalised"] = measures.normalise(row[name], rows[0][name])
    motion = experiment.motion
    return {
        "status": "diverged" if iterations[-1].trial.diverged else "done",
        "limits_hit": [
            {"k": None, "limit": name, "axis": axis, "time": time}
            for name, axis, time in motion.limits_hit
        ]
        + [
            {"k": it.trial.k, "limit": name, "axis": axis, "time": time}
            for it in iterations
            for name, axis, time in it.trial.result.recording.limits_hit
        ],
        "loop_error": _loop_error(experiment, iterations),
        "reached_speed": motion.reached_speed,
        "beam_lost": [not bool(it.trial.result.tracker.valid.all()) for it in iterations],
        "iterations": rows,
    }


def _loop_error(experiment: Experiment, iterations: list[Iteration]) -> float:
    """Widest opening of a closed chain over all runs but one that diverged [m]; 0 for none."""
    stride = experiment.job.ratio
    runs = [it.trial.result.recording for it in iterations if not it.trial.diverged]
    mj = experiment.job.model.mj
    return max((checked_loop_error(mj, run.truth.qpos[::stride]) for run in runs), default=0.0)


def quality(
    experiment: Experiment, iterations: list[Iteration], repeated: Sequence[Pass], beam: float
) -> dict[str, Any]:
    """The edge that a beam of that diameter [mm] leaves, and measures after ISO 9283 [m].

    repeated: runs with the last correction.
    """
    motion, curve = experiment.motion, experiment.task.curve
    cuts = [kerf(curve, it.arm.path, beam * 1e-3) for it in iterations]
    true_cuts = [kerf(curve, it.arm_true.path, beam * 1e-3) for it in iterations]
    runs = [it.trial.result for it in iterations]
    iso: dict[str, Any] = {"repetitions": len(repeated)}
    for suffix, samples in (("", _tracked), ("_true", _true)):
        each = [path_measures(motion, [samples(run)]) for run in runs]
        iso[f"path_accuracy{suffix}"] = [m.accuracy for m in each]
        iso[f"path_accuracy_in_plane{suffix}"] = [m.accuracy_in_plane for m in each]
        if repeated:
            together = path_measures(motion, [samples(run) for run in repeated])
            iso[f"path_accuracy_of_repetitions{suffix}"] = together.accuracy
            iso[f"path_repeatability{suffix}"] = together.repeatability
            iso[f"path_repeatability_in_plane{suffix}"] = together.repeatability_in_plane
    return {
        "kerf": {
            "beam": beam * 1e-3,
            "hole_roundness": [cut.roundness for cut in cuts],
            "hole_roundness_true": [cut.roundness for cut in true_cuts],
            "widest_true": [float(cut.width.max()) for cut in true_cuts],
        },
        "iso": iso,
    }


def _tracked(run: Pass) -> tuple[Array, Array]:
    return run.tracker.time, run.tracker.position


def _true(run: Pass) -> tuple[Array, Array]:
    return run.recording.truth.time, run.recording.truth.tool_position


def write(
    folder: RunFolder, experiment: Experiment, iterations: list[Iteration], outcome: dict[str, Any]
) -> None:
    """Write the files of a run, which together are all that replay and measure need."""
    import mujoco

    from armside.sim.records.robot_file import write_robot
    from armside.sim.records.signals import RecordedRun, write_signals
    from armside.sim.replay.run_scene import laser_scene
    from armside.sim.replay.scene import write_scenes

    from .figures import laser as figures

    (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    trials = [it.trial for it in iterations]
    runs = [
        RecordedRun(k=trial.k, recording=trial.result.recording, tracker=trial.result.tracker)
        for trial in trials
    ]
    config = outcome["config"]
    motion, model = experiment.motion, experiment.job.model
    write_signals(
        folder / "signals.parquet",
        runs,
        config=config,
        seed=config["seed"],
        motion=motion,
        gear=model.drives.gear,
    )
    source = config["model"] or CELLS[config["robot"]].xml
    write_robot(folder / "robot.xml", mujoco.MjSpec.from_file(str(source)))
    write_scenes(folder / "replay.rrd", [laser_scene(outcome, model.mj, runs, motion)])
    rows = outcome["iterations"]
    curve = experiment.task.curve
    figures.circles(
        folder / "circles.png",
        curve.point(np.linspace(0.0, curve.length, 361)),
        [it.arm.path for it in iterations],
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
    from .figures import kerf as kerf_figure

    beam, curve = measures["beam"], experiment.task.curve
    shown = [iterations[0], iterations[-1]] if len(iterations) > 1 else iterations
    cuts = [(it.trial.k, kerf(curve, it.arm_true.path, beam)) for it in shown]
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
