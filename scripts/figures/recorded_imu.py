"""Files, figures and tables of chapter 5 on recordings of a real robot."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from armside.sim.imu.chapter5_recorded import RecordedImu, mounting, repeatability, scale
from armside.sim.imu.phases import WINDOW
from armside.sim.recordings.alignment.imu_alignment import ImuAlignment
from armside.sim.records.run_folder import RunFolder

from ..shell.console import Report
from . import imu as figures

SHOWN = 40.0
"""[s] Of the judged half that figures show."""


def results(done: Sequence[RecordedImu]) -> dict[str, Any]:
    """Entries of summary.json. SI units."""
    found: dict[str, Any] = {"recordings": []}
    for one in done:
        held_out = vars(one.measures) | {"gravity_magnitude": one.measures.gravity_magnitude}
        row = {"recording": one.name, "constants": _constants(one.alignment), "held_out": held_out}
        found["recordings"].append(row)
    if len(done) > 1:
        found["repeatability"] = vars(repeatability([one.alignment for one in done]))
    return found


def _constants(one: ImuAlignment) -> dict[str, Any]:
    return {
        "gyro_offset": one.gyro_delay,
        "accelerometer_offset": one.accelerometer_delay,
        "clock_rate": one.rate,
        "gyro_scale": scale(one.M_gyro),
        "accelerometer_scale": scale(one.M_accelerometer),
        "M_gyro": one.M_gyro,
        "M_accelerometer": one.M_accelerometer,
        "gyro_bias": one.gyro_bias,
        "accelerometer_bias": one.accelerometer_bias,
        "mounting": mounting(one),
        "lever": one.lever,
        "gravity": one.gravity,
    }


def write(folder: RunFolder, done: Sequence[RecordedImu]) -> None:
    """Figures of each recording: motor angles, path of the IMU, and what was judged."""
    for one in done:
        suffix = f"-{one.name}" if len(done) > 1 else ""
        motion, seen = one.motion, one.comparison
        if motion.phi.shape[1] == 6:
            figures.motor_angles(folder / f"motor-angles{suffix}.png", motion.time, motion.phi)
        imu = motion.T[:, :3, 3] + motion.lever(one.alignment.lever)
        figures.path(folder / f"path{suffix}.png", imu)
        shown = seen.time < seen.time[0] + SHOWN
        figures.comparison(folder, suffix, seen, shown, slice(None), one.window_rms, WINDOW)
        if (tool := one.tool()) is not None:
            figures.position(folder / f"position{suffix}.png", *tool)


def tables(report: Report, done: Sequence[RecordedImu]) -> None:
    """Print error beside signal, the constants, and their repeatability."""
    for one in done:
        m = one.measures
        rows = [
            ("angular velocity, RMS [mrad/s]", *map(float, 1e3 * m.angular_velocity)),
            ("error of the prediction", *map(float, 1e3 * m.angular_velocity_error)),
            ("  of the signal [%]", *_percent(m.angular_velocity_error, m.angular_velocity)),
            ("acceleration, RMS [m/s²]", *map(float, m.acceleration)),
            ("error of the prediction", *map(float, m.acceleration_error)),
            ("  of the signal [%]", *_percent(m.acceleration_error, m.acceleration)),
        ]
        report.table(f"{one.name}: second half by the first", ["", *"xyz"], rows)
        report.line(
            f"gravity: {m.gravity_magnitude:.3f} m/s², {np.degrees(m.gravity_angle):.2f} degrees "
            f"from that of the first half; samples within {np.degrees(m.gravity_angle_rms):.2f} RMS"
        )
    head = ["", *(one.name for one in done)]
    report.table("Constants, whole recordings", head, _rows([one.alignment for one in done]))
    if len(done) > 1:
        found = repeatability([one.alignment for one in done])
        report.line(
            f"Largest difference between recordings: gyro scale {found.gyro_scale:.4f}, mounting "
            f"{np.degrees(found.mounting):.2f} degrees, accelerometer scale "
            f"{found.accelerometer_scale:.4f}, gravity {np.degrees(found.gravity):.2f} degrees"
        )
    report.line("The offset of each sensor is that of its clock and its delay together.")


def _percent(error: np.ndarray, signal: np.ndarray) -> list[float]:
    return [float(100.0 * part) for part in error / signal]


def _rows(constants: Sequence[ImuAlignment]) -> list[list[Any]]:
    def three(values: np.ndarray, form: str) -> str:
        return " ".join(f"{value:{form}}" for value in values)

    return [
        ["gyro offset [ms]", *(1e3 * one.gyro_delay for one in constants)],
        ["accelerometer offset [ms]", *(1e3 * one.accelerometer_delay for one in constants)],
        ["rate of the clock [ppm]", *(1e6 * one.rate for one in constants)],
        ["gyro scale", *(three(scale(one.M_gyro), ".3f") for one in constants)],
        ["accelerometer scale", *(three(scale(one.M_accelerometer), ".3f") for one in constants)],
        ["mounting [degrees]", *(three(np.degrees(mounting(one)), ".1f") for one in constants)],
        ["lever [mm]", *(three(1e3 * one.lever, ".0f") for one in constants)],
        ["gravity, base axes [m/s²]", *(three(one.gravity, ".2f") for one in constants)],
    ]
