"""Recorded signals of cuts, which a twin is identified from, and their tables on disk.

No ground truth. A table has the form of `signals.parquet`, whether a robot made it or we:

Columns reference_1..6, motor_angle_1..6 [rad, arm side], motor_torque_1..6 [N m, motor side] at
250 Hz; correction_1..6 [rad] where there was any; tracker_x, tracker_y, tracker_z [m, base axes] or
imu_acceleration_x..z [m/s^2], imu_angular_velocity_x..z [rad/s] in axes of the site `imu`, in rows
whose time is the sensor's own. Columns of the ground truth are not read.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from armside.arrays import Array, check_recorded_time
from armside.ilc.filters import ZeroPhaseButterworth

from ..estimation.relative_path import REST_SAMPLES, relative_to_start
from ..evaluation.recorded import notes_of_signals, notes_of_table
from ..instruments.imu import ImuCfg, ImuSamples
from ..instruments.laser_tracker import TrackerSamples
from ..laser.experiment import Pass
from ..motion.contour import ClosedCurve
from ..motion.path import Plane
from ..notes import Note
from ..records.files import InputError
from ..records.signals import missing_columns, signals_of
from ..records.tables import floats, read_table
from ..robot.mjcf import AXES
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from ..scan.reading import ScannedContour

_TRACKER_FILTER = 40.0
"""[Hz], zero-phase low-pass of tracker positions."""
SensorName = Literal["tracker", "imu", "scan"]
"""Sensor of the tool that a cut is identified from."""
TwinSensor = Literal["tracker", "imu", "scan", "imu and scan"]
"""What the cuts were seen by that a twin is identified from."""
_SIGNALS = "signals.parquet"
CONFIG = b"armside.config"
"""In the metadata of a table that we wrote."""
_LOG = ("reference", "motor_angle", "motor_torque")
_TRACKER, _ACCELERATION, _RATE = (
    tuple(f"{signal}_{c}" for c in "xyz")
    for signal in ("tracker", "imu_acceleration", "imu_angular_velocity")
)
_SENSORS: Mapping[SensorName, tuple[str, ...]] = {
    "tracker": _TRACKER,
    "imu": (*_ACCELERATION, *_RATE),
    "scan": (),
}
_CLOCK = 1e-6
"""[s], by which instants of the log may differ from its rate."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScannedCut:
    """What a scan of a sheet says of one cut, and where the contour is on the sheet."""

    contour: ScannedContour
    curve: ClosedCurve
    """As drawn, counter-clockwise around its middle."""
    middle: Array
    """(2,) [m], in the coordinates of the drawing."""
    plane: Plane
    """Of the contour, its origin at the contour's middle."""
    contour_time: tuple[float, float]
    """[s], of the log, at which the beam is on."""
    clockwise: bool
    number: int
    count: int
    """Place of the contour among those of the sheet, in the order in which they were cut."""
    scale: float
    """Standard deviation of the scanner's scale."""
    beam_measured: bool


class ImplausibleError(InputError):
    """A recording that cannot be of this robot, or not in the stated units."""


@dataclass(frozen=True, kw_only=True)
class MeasuredCut:
    """Recorded signals of one run at the log rate."""

    name: str
    reference: Array
    correction: Array
    motor_angle: Array
    """(N, 6) [rad], arm side."""
    motor_torque: Array
    """(N, 6) [N m], motor side."""
    tool: Array | None = None
    """(N, 3) [m], displacement of the tool from rest in base axes, by a tracker."""
    rest: Array | None = None
    """(3,) [m], position of the tool at rest in base axes, by the tracker."""
    imu: ImuSamples | None = None
    scan: "ScannedCut | None" = None

    @property
    def moving(self) -> np.ndarray:
        """(N,) bool: the reference moves."""
        still = (np.diff(self.reference, axis=0) == 0.0).all(axis=1)
        return ~np.concatenate((still[:1], still))


def measured(run: Pass, name: str = "cut") -> MeasuredCut:
    """The record of a pass without its ground truth. Raises ValueError for a beam that was lost."""
    tool, rest = tracked(run.recording.time, run.tracker, name)
    return replace(measured_from(run.recording, name), tool=tool, rest=rest, imu=run.imu)


def measured_from(log: Recording, name: str) -> MeasuredCut:
    """The record of a run without its instruments and its ground truth."""
    return MeasuredCut(
        name=name,
        reference=log.reference,
        correction=log.correction,
        motor_angle=log.motor_angle,
        motor_torque=log.motor_torque,
    )


def tracked(time: Array, samples: TrackerSamples, name: str) -> tuple[Array, Array]:
    """Low-passed displacement (N, 3) [m] from rest at the log's instants; position (3,) at rest."""
    if not samples.valid.all():
        lost = int(np.count_nonzero(~samples.valid))
        raise ValueError(f"{name}: the tracker lost {lost} of {len(samples.valid)} samples")
    period = float(samples.time[1] - samples.time[0])
    smooth = ZeroPhaseButterworth(_TRACKER_FILTER, period)(samples.position)
    at = np.clip(np.rint(time / period).astype(int), 0, len(smooth) - 1)
    return relative_to_start(smooth[at])[:, :3], smooth[at][:REST_SAMPLES].mean(axis=0)


def read_cut(source: Path, measure: SensorName = "tracker") -> MeasuredCut:
    """The first run of a folder of `armside laser`, or of a table of recorded data.

    measure: sensor of the tool that is read.

    Raises InputError where columns are missing, rates differ, or the beam was lost.
    """
    table = _table(source)
    if table.num_rows == 0:
        raise InputError(f"{source} is no recorded cut: it has no rows")
    if "k" in table.column_names:
        table = table.filter(pc.field("k") == pc.scalar(table["k"][0].as_py()))
    try:
        return _cut(table, source.name, measure)
    except (KeyError, ValueError) as error:
        text = error.args[0] if error.args else error
        raise InputError(f"{source} is no recorded cut: {text}") from error


def notes_of_first_run(source: Path) -> list[Note]:
    """Limits that changed the run that `read_cut` reads, as far as the recording tells. Raises
    InputError for what is no table."""
    table = _table(source)
    if CONFIG not in (table.schema.metadata or {}) or missing_columns(table):
        return notes_of_table(table)
    signals = signals_of(table, source=source.name)
    return notes_of_signals(replace(signals, runs=signals.runs[:1]))


def _table(source: Path) -> pa.Table:
    file = source / _SIGNALS if source.is_dir() else source
    try:
        return read_table(file)
    except (OSError, ValueError, pa.ArrowInvalid) as error:
        raise InputError(f"{source} is no recorded cut: {error}") from error


def _cut(table: pa.Table, name: str, measure: SensorName) -> MeasuredCut:
    needed = ["time", *(f"{signal}_{i}" for signal in _LOG for i in AXES), *_SENSORS[measure]]
    if missing := [column for column in needed if column not in table.column_names]:
        raise ValueError(f"it lacks the column {missing[0]}")
    log = table.filter(table["reference_1"].is_valid())
    time = _time(log, "log")
    if len(time) < 2 or np.abs(np.diff(time) - LOG_PERIOD).max() > _CLOCK:
        raise ValueError(f"its log is not at {1 / LOG_PERIOD:g} Hz")
    reference, angle, torque = (_columns(log, [f"{s}_{i}" for i in AXES]) for s in _LOG)
    correction = np.zeros_like(reference)
    if f"correction_{AXES[0]}" in table.column_names:
        correction = _columns(log, [f"correction_{i}" for i in AXES])
    cut = MeasuredCut(
        name=name,
        reference=reference,
        correction=correction,
        motor_angle=angle,
        motor_torque=torque,
    )
    if measure == "imu":
        return replace(cut, imu=_imu(table, float(time[0])))
    if measure == "scan":
        return cut
    seen = table.filter(table["tracker_x"].is_valid())
    position, own = _columns(seen, _TRACKER), _time(seen, "tracker")
    if len(own) < 2:
        raise ValueError("it has no samples of a laser tracker")
    valid = np.asarray(np.isfinite(position).all(axis=1))
    samples = TrackerSamples(time=own - time[0], position=position, valid=valid)
    tool, rest = tracked(time - time[0], samples, name)
    return replace(cut, tool=tool, rest=rest)


def _imu(table: pa.Table, start: float) -> ImuSamples:
    """Samples on the unit's clock, less the robot's time at the start of the log."""
    seen, cfg = table.filter(table[_ACCELERATION[0]].is_valid()), ImuCfg()
    acceleration, rate = _columns(seen, _ACCELERATION), _columns(seen, _RATE)
    return ImuSamples(
        time=_time(seen, "IMU") - start,
        acceleration=acceleration,
        angular_velocity=rate,
        acceleration_clipped=np.abs(acceleration) >= cfg.accelerometer.range,
        angular_velocity_clipped=np.abs(rate) >= cfg.gyroscope.range,
    )


def _time(table: pa.Table, stream: str) -> Array:
    time = floats(table, "time")
    check_recorded_time(stream, time)
    return time


def _columns(table: pa.Table, names: Sequence[str]) -> Array:
    return np.stack([floats(table, name) for name in names], axis=1)
