"""Sections of the report on measurements of real arms, from folders that the reader has.

Bands are those that docs/real.md states; the sets and where they come from stand there too.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from armside.kinematics import CATALOGUE
from armside.kinematics.calibration import (
    Calibration,
    CalibrationCfg,
    JointErrors,
    calibrate,
)
from armside.sim.evaluation.check import Check, Table
from armside.sim.gears import analyse_gears
from armside.sim.imu.chapter5_recorded import process, repeatability
from armside.sim.recordings import MotionRecording, read_motion, read_poses
from armside.sim.recordings.paths import compare_logs
from armside.sim.recordings.paths.waypoint_path import read_path_logs

from ..figures import calibration as of_calibration
from ..figures import gears as of_gears
from ..figures import imu as of_imu
from ..figures import path_logs as of_paths
from ..shell.errors import InputError
from .report import AbsentError, Asked, Entry, Part, Section

MM, UM = 1e3, 1e6
SERIES_C = "measurements_random_poses.csv"
RUNS = 3
"""Of the virtual robot at each speed."""


def ur10(seed: int, data: Path, folder: Path) -> Section:
    """UR10 with a T-Mac: the second half of series C by the first, and by 50 poses."""
    arm, poses = CATALOGUE["ur10"], read_poses(data / SERIES_C).measurements
    half = calibrate(arm, poses, CalibrationCfg(in_order=True), seed=seed)
    few = CalibrationCfg(poses=50, joint_errors=JointErrors(40, True))
    fifty = [calibrate(arm, poses, few, seed=seed + k).errors("full").mean for k in range(5)]
    of_calibration.draw_residuals(folder / "real-ur10.png", half)
    full = half.errors("full")
    checks = [
        _at_most("R1.1", "geometry, mean [mm]", MM * half.errors("geometry").mean, 0.46),
        _at_most("R1.2", "with joint harmonics, mean [mm]", MM * full.mean, 0.12),
        _at_most("R1.3", "the same, 95 % [mm]", MM * full.p95, 0.25),
        _at_most("R1.4", "50 poses, median mean of 5 draws [mm]", MM * np.median(fifty), 0.25),
        _equal("R1.5", "rank of the identifiable parameters", half.identifiable.all.rank, 27),
    ]
    caption = "Held-out error of the tool. Joint harmonics interpolate only."
    title = "UR10: kinematic calibration"
    return Section("real-ur10", title, caption, ["real-ur10.png"], checks, [_held_out(half)])


def irb120(seed: int, data: Path, folder: Path) -> Section:
    """IRB120 with three reflectors: half of the poses by the other."""
    source = read_poses(data)
    done = calibrate(CATALOGUE["irb120"], source.measurements, seed=seed)
    of_calibration.draw_residuals(folder / "real-irb120.png", done)
    mean = MM * done.errors("full").mean
    checks = [
        _at_most("R2.1", "with all errors, mean [mm]", mean, 0.40),
        _equal("R2.2", "rank of the identifiable parameters", done.identifiable.all.rank, 33),
    ]
    left_out = ". ".join(note.rpartition(":")[0] for note in source.notes)
    caption = f"Held-out error of the reflectors. {left_out}."
    title = "IRB120: kinematic calibration"
    return Section("real-irb120", title, caption, ["real-irb120.png"], checks, [_held_out(done)])


def imu(seed: int, data: Path, folder: Path) -> Section:
    """AUBO i5: chapter 5 on each day, and the constants over the days."""
    arm = CATALOGUE["aubo_i5"]
    done = [process(arm, day) for day in _days(data)]
    found, one = repeatability([day.alignment for day in done]), done[0]
    comparison = one.comparison
    pair = comparison.angular_velocity_measured, comparison.angular_velocity_predicted
    of_imu.vector(folder / "real-imu.png", comparison.time, *pair, quantity="angular_velocity")
    rows: list[Sequence[object]] = []
    for day in done:
        m = day.measures
        turns = m.angular_velocity_error / m.angular_velocity
        parts = (*turns, *(m.acceleration_error / m.acceleration))
        rows.append([day.name, *(round(100.0 * float(part), 1) for part in parts)])
    head = ["day", *(f"{name} {a} [%]" for name in ("ω", "a") for a in "xyz")]
    checks = [
        _at_most("R3.1", "gyro scale, largest difference of days", found.gyro_scale, 0.005),
        _at_most("R3.2", "mounting [degrees]", np.degrees(found.mounting), 0.2),
    ]
    caption = "Error of the predicted IMU over its signal, on the half that was not fitted."
    table = Table("Error over signal", head, rows)
    title = "AUBO i5: the IMU of chapter 5"
    return Section("real-imu", title, caption, ["real-imu.png"], checks, [table])


def gears(seed: int, data: Path, folder: Path) -> Section:
    """AUBO i5: gear error by the IMU of other days, and the fused position, against cameras."""
    done = analyse_gears(CATALOGUE["aubo_i5"], _days(data))
    of_gears.draw_scan(folder / "real-gears-scan.png", done)
    of_gears.draw_fused(folder / "real-gears-fused.png", done)
    judged = [one for one in done.judgements if one.tool and one.sham_tool and one.smoothed]
    ratios = [one.tool.pooled for one in judged if one.tool]
    shams = [one.sham_tool.pooled for one in judged if one.sham_tool]
    fused = [one.smoothed.pooled for one in judged if one.smoothed]
    rows = [
        [one.recording, "{:g}-{:g}".format(*b.band), UM * b.rms, UM * b.floor, b.gears, b.fused]
        for one in judged
        for b in one.bands
    ]
    head = ["day", "Hz", "encoders [µm]", "floor [µm]", "gears", "+ IMU"]
    second = sorted(ratios)[min(1, len(ratios) - 1)] if ratios else np.nan
    checks = [
        _at_most("R4.1", "4-12 Hz, gear error: second best day", second, 0.70),
        _at_most("R4.2", "the same, worst day", max(ratios, default=np.nan), 0.78),
        _at_most("R4.3", "with the IMU, worst day", max(fused, default=np.nan), 0.70),
        Check("R4.4", "sham orders", "", min(shams, default=np.nan), low=0.98),
    ]
    caption = "RMS of the tool's error by the cameras with the estimate, over that without."
    figures = ["real-gears-scan.png", "real-gears-fused.png"]
    title = "AUBO i5: gear error and fused position"
    return Section("real-gears", title, caption, figures, checks, [Table("Bands", head, rows)])


def paths(seed: int, data: Path, folder: Path) -> Section:
    """IRB6640: motor logs of a path beside the virtual large robot."""
    done = compare_logs(CATALOGUE["large"], read_path_logs(data), RUNS, seed)
    of_paths.draw(folder / "real-paths.png", done)
    worst = max(abs(one.real.scatter / one.perfect.mean() - 1.0) for one in done.speeds)
    rows = [
        [MM * v for v in (o.speed, o.real.error_in_plane, o.virtual.error_in_plane, o.real.scatter)]
        + [MM * float(o.perfect.mean()), MM * o.virtual.scatter]
        for o in done.speeds
    ]
    head = ["mm/s", "error", "virtual", "scatter", "log of perfect runs", "virtual"]
    checks = [_at_most("R5.1", "scatter less that of its log, relative", worst, 0.15)]
    caption = "Error in the plane of the path, mean removed, and scatter, motor side."
    table = Table("Across the path [mm]", head, rows)
    title = "IRB6640: motor logs of a path"
    return Section("real-paths", title, caption, ["real-paths.png"], checks, [table])


SETS: dict[str, tuple[str, Callable[[int, Path, Path], Section]]] = {
    "real-ur10": ("ur10_tmac", ur10),
    "real-irb120": ("irb120_faro", irb120),
    "real-imu": ("aubo_i5", imu),
    "real-gears": ("aubo_i5", gears),
    "real-paths": ("irb6640_logs", paths),
}
"""Id: folder of its set, and the function that draws it."""


def _part(name: str, asked: Asked) -> Part:
    """Raises InputError without a folder of data, AbsentError where it lacks the set."""
    folder, make = SETS[name]
    if asked.data is None or not asked.data.is_dir():
        raise InputError("measurements of real arms need --data FOLDER, which holds their sets")
    if not (asked.data / folder).is_dir():
        known = ", ".join(sorted({folder for folder, _ in SETS.values()}))
        raise AbsentError(f"{asked.data} has no folder {folder}. Sets: {known}")
    draw = partial(make, asked.seed, asked.data / folder)
    return Part([], lambda _, figures: draw(figures))


ENTRIES = [Entry(name, partial(_part, name)) for name in SETS]
"""Sections in the order of the report."""


def _days(data: Path) -> list[MotionRecording]:
    days = [folder for folder in sorted(data.iterdir()) if folder.is_dir()]
    if len(days) < 2:
        raise InputError(f"{data} needs the folders of two days, got {len(days)}")
    return [read_motion(day) for day in days]


def _held_out(done: Calibration) -> Table:
    rows = [[n, *(MM * v for v in done.errors(n))] for n in ("nominal", "geometry", "full")]
    return Table("Held-out error [mm]", ["model", "mean", "95 %", "largest"], rows)


def _at_most(id: str, statement: str, ours: float, high: float) -> Check:
    return Check(id, statement, "", float(ours), high=high)


def _equal(id: str, statement: str, ours: float, value: float) -> Check:
    return Check(id, statement, "", ours, low=value, high=value)
