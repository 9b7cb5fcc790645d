"""Repair of streams, and recordings as folders of tables."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from armside.sim.recordings import is_motion, read_motion
from armside.sim.recordings.recorded_motion import repaired

TIME = np.arange(0.0, 20.0, 0.01)
PHI = np.column_stack([np.sin(0.5 * TIME), np.cos(0.3 * TIME)])


def test_held_samples_missing_rows_and_repeated_stamps_are_dropped_and_counted():
    time, phi = TIME.copy(), PHI.copy()
    held = np.array([300, 700, 1500])
    phi[held] = phi[held - 1]
    phi[900, 1] = np.nan
    time[1200] = time[1199]
    stream, notes = repaired("encoders", time, phi)
    assert not set(TIME[held]) & set(stream.time)
    assert len(stream.time) == len(TIME) - 5
    assert "1 not finite, 1 with a repeated or older stamp, 3 off their neighbours" in notes[0]


def test_a_spike_is_dropped_and_noise_is_kept():
    noise = np.random.default_rng(0).normal(0.0, 1e-3, PHI.shape)
    phi = PHI + noise
    phi[70] += 1.0
    stream, notes = repaired("IMU", TIME, phi)
    np.testing.assert_array_equal(stream.time, np.delete(TIME, 70))
    assert "1 off their neighbours" in notes[0]


def test_gaps_are_told_and_stamps_are_kept():
    rows = np.r_[0:800, 900 : len(TIME)]
    stream, notes = repaired("IMU", TIME[rows], PHI[rows])
    assert np.array_equal(stream.time, TIME[rows])
    assert notes == ("IMU: 1 gaps are bridged, the longest 1010 ms",)


def exchanged(every):
    """Stamps of which each so many-th pair is in the wrong order."""
    time = TIME.copy()
    time[::every], time[1::every] = TIME[1::every], TIME[::every]
    return time


@pytest.mark.parametrize(
    ("time", "values", "said"),
    [
        (TIME[::-1], PHI, "clock runs backwards"),
        (exchanged(every=20), PHI, "clock runs backwards, first in sample 2"),
        (np.where(TIME < 12.0, TIME, TIME - 9.0), PHI, "the clock is set back"),
        (TIME[:50], PHI[:50], "50 samples"),
        (1e6 * TIME, PHI, "one sample each 1e+04 s; 1e-05 to 0.5 s can be right"),
        (1e3 * TIME, PHI, "are they in milliseconds?"),
        (1e-4 * TIME, PHI, "are they in minutes or hours?"),
        (TIME, 1e300 * PHI, "values reach 1e+300"),
        (TIME, np.where(TIME[:, None] < 10.0, np.nan, PHI), "50 % of the samples are not finite"),
    ],
)
def test_what_cannot_be_repaired_is_refused_by_name(time, values, said):
    with pytest.raises(ValueError, match="encoders: ") as error:
        repaired("encoders", time, values)
    assert said in str(error.value)


@pytest.mark.parametrize("left_out", [None, "signals.parquet", "summary.json"])
def test_a_run_is_a_recording_by_its_signals_and_its_summary(tmp_path, left_out):
    for name in {"signals.parquet", "summary.json"} - {left_out}:
        (tmp_path / name).touch()
    assert is_motion(tmp_path) == (left_out is None)


def test_a_folder_of_tables_is_read(tmp_path):
    rows = np.column_stack([TIME, PHI])
    header = "time,motor_angle_1,motor_angle_2"
    np.savetxt(tmp_path / "encoders.csv", rows, "%.17g", ",", header=header, comments="")
    one = read_motion(tmp_path)
    assert np.array_equal(one.encoders.values, PHI)
    assert (one.imu, one.tracker, one.form) == (None, None, "folder of tables")
    (tmp_path / "imu.csv").write_text("time,acceleration_x\n0,1\n")
    with pytest.raises(ValueError, match="columns are missing: acceleration_y"):
        read_motion(tmp_path)
    with pytest.raises(ValueError, match="no recording of a known form"):
        read_motion(tmp_path.parent)


def test_a_rest_whose_readings_repeat_makes_no_motion_a_fault():
    """Most of the record is at rest, where a reading is exactly the one before."""
    time = np.r_[TIME[0] - (TIME[1] - TIME[0]) * np.arange(3 * len(TIME), 0, -1), TIME]
    values = np.maximum(time - TIME[0], 0.0)[:, None] ** 4
    noisy = values + np.random.default_rng(0).normal(0.0, 1e-6, values.shape) * (values > 0.0)
    stream, notes = repaired("encoders", time, noisy)
    assert (len(stream.time), notes) == (len(time), ())


def test_a_corner_and_a_count_at_rest_are_no_spikes():
    """Axes that stop and turn at once, read in counts, of which one toggles while they stand."""
    time, count = 0.004 * np.arange(1000), 1e-6
    asked = np.select([time < 1.0, time < 2.0, time < 3.0], [0.0, 0.2, -0.3], 0.0)
    speed = gaussian_filter1d(asked, 3.0)
    angle = np.cumsum(np.column_stack([speed, 0.4 * speed]), axis=0) * 0.004
    noise = np.random.default_rng(0).normal(0.0, 0.3 * count, angle.shape)
    values = count * np.round((angle + (speed != 0.0)[:, None] * noise) / count)
    values[100] += count
    stream, notes = repaired("encoders", time, values)
    assert (len(stream.time), notes) == (len(time), ())


@pytest.mark.parametrize("begin", [np.inf, 9.5])
@pytest.mark.parametrize("spikes", [[300], [100, 300, 500, 700, 900], [975]])
def test_a_spike_in_a_record_at_rest_is_dropped(begin, spikes):
    """Still but for a short, slow motion of encoders with noise."""
    time = 0.01 * np.arange(1000)
    noise = np.random.default_rng(0).normal(0.0, 1e-5, 1000)
    values = np.where(time > begin, np.maximum(time - min(begin, 10.0), 0.0) ** 3 + noise, 0.0)
    values[spikes] += 0.5
    stream, notes = repaired("encoders", time, values[:, None])
    np.testing.assert_array_equal(stream.time, np.delete(time, spikes))
    assert f"{len(spikes)} off their neighbours" in notes[0]
