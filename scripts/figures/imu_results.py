"""Files, figures and tables of an IMU experiment."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from armside.sim.imu import ImuResult
from armside.sim.imu.phases import WINDOW
from armside.sim.imu.vibration import RestResult
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.signals import RecordedRun, write_signals
from armside.sim.robot.mjcf import write_robot

from ..shell.console import Report
from . import imu as figures


def write_runs(results: Sequence[ImuResult], folder: RunFolder, config: dict[str, Any]) -> None:
    """Write signals.parquet, robot.xml, imu.parquet, replay.rrd and the figures of each program."""
    from armside.sim.imu.imu_files import write_imu_replay, write_imu_signals

    runs = [RecordedRun(k=k, recording=one.run.recording) for k, one in enumerate(results)]
    write_signals(folder / "signals.parquet", runs, config=config, seed=config["seed"])
    write_robot(folder / "robot.xml", results[0].experiment.spec())
    write_imu_signals(folder / "imu.parquet", results, config=config)
    write_imu_replay(folder / "replay.rrd", results)
    for one in results:
        suffix = f"-{one.planned.name}" if len(results) > 1 else ""
        recording, evaluation, cell = one.run.recording, one.evaluation, one.experiment.cell
        file, angles = folder / f"motor-angles{suffix}.png", recording.motor_angle
        figures.motor_angles(file, recording.time, angles, cell.robot.slides)
        figures.path(folder / f"path{suffix}.png", one.imu_position)
        tool = evaluation.tool, evaluation.tool_predicted
        figures.position(folder / f"position{suffix}.png", recording.time, *tool)
        seen, rms = evaluation.comparison, evaluation.window_rms
        late = seen.time >= one.planned.since
        figures.comparison(folder, suffix, seen, slice(None), late, rms, WINDOW)


def error_tables(results: Sequence[ImuResult], report: Report) -> None:
    """Print the error measures of each program."""
    for one in results:
        m = one.measures
        rows = [
            ("angular velocity error, RMS [mrad/s]", 1e3 * m.angular_velocity_rms),
            ("angular velocity error, largest [mrad/s]", 1e3 * m.angular_velocity_max),
            ("acceleration error, RMS [m/s²]", m.acceleration_rms),
            (f"acceleration error, largest RMS over {WINDOW:g} s", m.acceleration_window_max),
            ("  at [s]", m.acceleration_window_time),
            ("acceleration, largest [m/s²]", m.acceleration_peak),
        ]
        head = ["from the end of synchronisation", *"xyz"]
        report.table(one.planned.name, head, [(name, *map(float, v)) for name, v in rows])
        report.line(
            f"clocks: {1e3 * one.evaluation.comparison.clock_offset:.2f} ms apart, found within "
            f"{1e3 * abs(m.clock_offset_error):.2f} ms; tool to motor-angle D-H: at most "
            f"{1e3 * m.tool_distance:.2f} mm; loop open by {1e6 * m.loop_error:.3f} µm; "
            f"{100 * m.clipped_share:.1f} % clipped"
        )
        if np.isfinite(m.idle_peaks).any():
            peaks = [
                f"motor {i} {1e4 * p:.1f}" for i, p in enumerate(m.idle_peaks, 1) if np.isfinite(p)
            ]
            unit = "rad, m of a slide" if any(one.experiment.cell.robot.slides) else "rad"
            report.line(f"idle motors are moved by others by {', '.join(peaks)} × 1e-4 {unit}")
        for move in one.planned.motion.reports:
            if move.limited_by and move.programmed.path is not None:
                report.line(
                    f"move at {move.start:.2f} s: {move.reached:.2f} of "
                    f"{move.programmed.path:.2f} m/s, limited by {move.limited_by}"
                )


def write_rest(result: RestResult, folder: RunFolder, config: dict[str, Any]) -> None:
    """Write signals.parquet, robot.xml and the figures of an experiment at rest."""
    run, rest, file = result.run, result.rest, folder / "signals.parquet"
    signals = [RecordedRun(k=0, recording=run.recording)]
    write_signals(file, signals, config=config, seed=config["seed"], truth_rate=250.0)
    write_robot(folder / "robot.xml", result.experiment.spec())
    figures.rest(folder / "rest.png", run.samples.time, run.samples.acceleration, config["off"])
    figures.spectrum(folder / "spectrum.png", rest.frequency, rest.off_spectrum, rest.on_spectrum)


def rest_table(result: RestResult, report: Report) -> None:
    """Print the vibration at rest."""
    names = ("motors off, RMS", "motors on, RMS", "motors on, exceeded by 0.3 %")
    levels = (result.rest.off_rms, result.rest.on_rms, result.rest.on_level)
    rows = [(name, *map(float, values)) for name, values in zip(names, levels, strict=True)]
    report.table("Acceleration at rest [m/s²]", ["", *"xyz"], rows)
