"""Every reader of recorded times refuses those that cannot be, with column, row and value."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from armside.arrays import check_recorded_time
from armside.ilc.workbench.signals import read_signal
from armside.sim.controller.stored_correction import read_correction
from armside.sim.evaluation.recorded import measure_table
from armside.sim.recordings.logs import read_log
from armside.sim.recordings.recorded_motion import repaired
from armside.sim.recordings.tables import read_motion_tables
from armside.sim.records.tables import read_table, write_table
from armside.sim.twin.recordings import read_cut

TIME = np.arange(300) * 0.004
VALUE = np.sin(TIME)


def table(time, *names):
    return pa.table({"time": time, **dict.fromkeys(names, VALUE)})


def own_form(time, folder):
    file = folder / "mine.csv"
    write_table(file, table(time, "reference_1", "motor_angle_1"))
    measure_table(read_table(file), [1.0], None)


def tables(time, folder):
    write_table(folder / "encoders.csv", table(time, "motor_angle_1"))
    read_motion_tables(folder)


def log(time, folder):
    rows = ["timestamp,J1", *(f"{t!r},{v!r}" for t, v in np.c_[time, VALUE].tolist())]
    (folder / "log.csv").write_text("\n".join(rows))
    read_log(folder / "log.csv")


def correction(time, folder):
    write_table(folder / "u.csv", table(time, "correction_1"))
    read_correction(folder / "u.csv")


def signal(time, folder):
    np.savetxt(folder / "s.csv", np.c_[time, VALUE], "%.17g", ",", header="time,u", comments="")
    read_signal(folder / "s.csv")


def cut(time, folder):
    names = [f"{n}_{i}" for n in ("reference", "motor_angle", "motor_torque") for i in range(1, 7)]
    imu = [f"imu_{n}_{c}" for n in ("acceleration", "angular_velocity") for c in "xyz"]
    pq.write_table(table(time, *names, *imu), folder / "cut.parquet")
    read_cut(folder / "cut.parquet", "imu")


READERS = [own_form, tables, log, correction, signal, cut]
WRONG = {
    "reversed": (TIME[::-1], "column time, row 2: time must increase"),
    "in milliseconds": (1e3 * TIME, "column time, row 2: one sample each 4 s"),
    "in hours": (TIME / 3600.0, "column time, row 2: one sample each 1.111e-06 s"),
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("read", READERS)
def test_a_reader_refuses_times_with_row_and_value(read, name, tmp_path):
    time, said = WRONG[name]
    if read is signal and name != "reversed":  # of any plant, at any rate
        return read(time, tmp_path)
    said = "backwards|runs|older" if (read, name) == (tables, "reversed") else said
    read(TIME, tmp_path)
    with pytest.raises(ValueError, match=said):
        read(time, tmp_path)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_time_that_is_none_is_named_by_its_row_in_the_table(value):
    time = TIME.copy()
    time[7] = value
    with pytest.raises(ValueError, match=rf"mine: column time, row 18: .*got {value}"):
        check_recorded_time("mine", time, np.arange(10, 310))


def test_repeated_stamps_are_allowed_where_stamps_are_rounded():
    stamps = np.repeat(TIME[::2], 2)
    check_recorded_time("log", stamps, repeats=True)
    with pytest.raises(ValueError, match=r"row 2: .*stands still"):
        check_recorded_time("log", stamps)


def test_a_gap_is_named_by_the_row_before_it():
    check_recorded_time("log", TIME + 0.9 * (TIME > 0.5))
    with pytest.raises(ValueError, match=r"row 126: no samples for 1.1 s after 0.5 s; at most 1 s"):
        check_recorded_time("log", TIME + 1.1 * (TIME > 0.5) - 0.004 * (TIME > 0.5))


def test_dropped_samples_keep_the_rows_of_the_table():
    time = np.where(np.arange(300) < 50, np.nan, 1e3 * TIME)
    with pytest.raises(ValueError, match="in milliseconds"):
        repaired("encoders", time, VALUE[:, None])


def test_numbers_written_as_text_are_no_times():
    texts = table(TIME, "reference_1", "motor_angle_1").set_column(0, "time", [map(str, TIME)])
    with pytest.raises(ValueError, match=r"column time, row 1: numbers are needed, got '0.0'"):
        measure_table(texts, [1.0], None)


def test_the_sample_where_a_clock_first_runs_backwards_is_counted_from_one():
    time = -0.004 * np.abs(np.arange(300) - 6.0)  # the seventh is the latest
    with pytest.raises(ValueError, match=r"runs backwards, first in sample 8$"):
        repaired("encoders", time, VALUE[:, None])
