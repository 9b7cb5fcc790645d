"""Logs of controllers as tables in SI."""

import re
from typing import Any

import numpy as np
import pytest

from armside.sim.recordings.logs import read_log

N = 20
TIME = 0.004 * np.arange(N)
DEGREES = np.column_stack([10.0 + 90.0 * TIME, -20.0 * TIME])
ANGLES = np.radians(DEGREES)


def columns(log, name):
    return np.column_stack([log.table[f"{name}_{i}"].to_numpy() for i in (1, 2)])


def check(log, reference=None):
    np.testing.assert_allclose(log.table["time"].to_numpy(), TIME, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(columns(log, "motor_angle"), ANGLES, rtol=1e-12)
    if reference is not None:
        np.testing.assert_allclose(columns(log, "reference"), reference, rtol=1e-12)


def text(file, header, rows, separator=", "):
    lines = [separator.join(f"{x!r}" if isinstance(x, float) else x for x in row) for row in rows]
    file.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    return file


def numbers(*blocks):
    return [[float(x) for x in row] for row in np.column_stack(blocks)]


def test_a_log_of_an_abb_rapid_task_is_read(tmp_path):
    rows = [
        [f"{t:.3f}", "-1", *map(repr, map(float, phi))]
        for t, phi in zip(TIME, DEGREES, strict=True)
    ]
    rows[3][2] = ""
    log = read_log(text(tmp_path / "log.csv", "timestamp, cmd_num, J1, J2", rows))
    assert log.form == "ABB, log of a RAPID task"
    assert log.table.num_rows == N - 1
    assert "1 rows without a number" in log.notes[1]
    np.testing.assert_allclose(columns(log, "motor_angle"), np.delete(ANGLES, 3, 0), rtol=1e-12)


def test_a_kuka_rsi_log_is_read_by_the_controllers_clock_or_by_dates(tmp_path):
    names = [f"Send.{kind}.A{i}" for kind in ("ASPos", "AIPos") for i in (1, 2)]
    dates = [f"22/11/2026 10:20:59.{984 + 4 * k:03d}" for k in range(4)]
    dates += [f"22/11/2026 10:21:00.{4 * k:03d}" for k in range(N - 4)]
    clock = [f"{4208163634 + 4 * k}" for k in range(N)]
    logged = numbers(DEGREES + 1, DEGREES)
    for used, header in ((clock, ["Timestamp", *names, "Send.IPOC"]), (dates, names)):
        rows = [[date, *map(str, row)] for date, row in zip(dates, logged, strict=True)]
        if used is clock:
            rows = [[*row, stamp] for row, stamp in zip(rows, clock, strict=True)]
        else:
            header = ["Timestamp", *names]
        log = read_log(text(tmp_path / "rsi.csv", ",".join(header), rows, ","))
        assert log.form.endswith("by its clock") == (used is clock)
        check(log, np.radians(DEGREES + 1))


def trace(folder, n=N, unit="°", extra=""):
    names = [f"AxisPos_{kind}{i}" for i in (1, 2) for kind in ("CmdIpo", "Act")]
    values = np.column_stack([DEGREES[:, [i, i]] + [1.0, 0.0] for i in (0, 1)])
    values.astype("<f8").tofile(folder / "a_KRCIpo.r64")
    header = ["DIAEXTENDED", "#BEGINCHANNELHEADER", "200,Zeit", "202,s", "210,IMPLIZIT"]
    header += [f"220,{n}", "240,0", "241,0.004", "#ENDCHANNELHEADER"]
    for place, name in enumerate(names, 1):
        header += ["#BEGINCHANNELHEADER", f"200,{name}", f"202,{unit}", "210,EXPLIZIT"]
        header += ["211,D:\\TRACE\\a_KRCIpo.r64", "213,BLOCK", "214,REAL64", f"220,{n}"]
        header += [f"221,{place}", "240,0", "241,1", "#ENDCHANNELHEADER"]
    file = folder / "a_KRCIpo.dat"
    file.write_text("\n".join([*header, extra]), encoding="latin-1")
    return file


def test_a_kuka_trace_is_read_from_its_file_and_from_its_text(tmp_path):
    check(read_log(trace(tmp_path)), np.radians(DEGREES + 1))
    header = "Zeit [s]\tAxisPos_Act1 [°]\tAxisPos_Act2 [°]"
    rows = [[f"{x:.17g}".replace(".", ",") for x in row] for row in numbers(TIME, DEGREES)]
    check(read_log(text(tmp_path / "trace.txt", header, rows, "\t")))


def test_damaged_traces_are_named(tmp_path):
    wrong: tuple[tuple[dict[str, Any], str], ...] = (
        ({"n": N + 1}, r"a_KRCIpo\.r64 has 80 values"),
        ({"n": 10**12}, "unpacks to"),
        ({"unit": "mm"}, r"the unit of AxisPos_Act1 must be .* the header has 'mm'"),
        ({"extra": "#BEGINCHANNELHEADER\n200,x\n210,IMPLIZIT\n#ENDCHANNELHEADER"}, "key 220"),
    )
    for changed, said in wrong:
        with pytest.raises(ValueError, match=said):
            read_log(trace(tmp_path, **changed))
    file = trace(tmp_path)
    file.write_bytes(file.read_bytes().replace(b"221,2", b"221,9"))  # of four columns
    with pytest.raises(ValueError, match=r"AxisPos_Act1 begins at 9$"):
        read_log(file)
    (tmp_path / "a_KRCIpo.r64").unlink()
    with pytest.raises(ValueError, match="does not exist"):
        read_log(tmp_path / "a_KRCIpo.dat")
    (file := tmp_path / "zero.dat").write_bytes(bytes(1000))
    with pytest.raises(ValueError, match="0 channels"):
        read_log(file)


MAPPING = 'time = "t"\ntime_unit = "ms"\nmotor_angle = "q{}"\nreference = ["r1", "r2"]\n'


def test_any_log_is_read_by_a_file_of_columns(tmp_path):
    header = "t;q1 [deg];q2 [deg];r1 (rad);r2 (rad);other"
    rows = [[*row, "word"] for row in numbers(1e3 * TIME + 5e9, DEGREES, 2.0 * ANGLES)]
    log = text(tmp_path / "own.csv", header, rows, ";")
    with pytest.raises(ValueError, match=r"no log of a known form \(columns t, .*--columns FILE"):
        read_log(log)
    (file := tmp_path / "columns.toml").write_text(MAPPING)
    check(read_log(log, file), 2.0 * ANGLES)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("time_unit", "clock"), "unknown key clock. Keys: time, time_unit"),
        (('"ms"', '"min"'), "time_unit must be one of s, ms"),
        (('"ms"', '"%H:%M"'), "is no date of the form %H:%M"),
        (('"t"', '"x"'), "has no column x. Columns: t, q1"),
        (('"q{}"', '"p{}"'), "has no columns p{}"),
        (('"q{}"', "3"), "must be a text with {} or a list"),
        (('"q{}"', '["q1", "q2", "q1"]'), "reference must name 3 columns"),
        (('time = "t"', ""), "lacks the key time"),
        (("= [", "= [["), "cannot be read"),
    ],
)
def test_a_wrong_file_of_columns_is_named(tmp_path, change, said):
    header = "t,q1 [deg],q2 [deg],r1 [rad],r2 [rad]"
    log = text(tmp_path / "own.csv", header, numbers(TIME, DEGREES, ANGLES), ",")
    (file := tmp_path / "columns.toml").write_text(MAPPING.replace(*change))
    with pytest.raises(ValueError, match=re.escape(said)):
        read_log(log, file)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda rows: [[t, 1e9, b] for t, _, b in rows], "are the units as stated"),
        (lambda rows: rows[::-1], "column time, row 2: time must increase"),
        (lambda rows: [[t, float("nan"), b] for t, _, b in rows], "20 of 20 rows lack a number"),
        (lambda rows: rows[:1], "at least 2 rows"),
        (lambda rows: [[t, "far", b] for t, _, b in rows], "column J1"),
        (lambda _: [], "J1|rows"),
    ],
)
def test_what_cannot_be_right_is_one_error(tmp_path, change, said):
    file = text(tmp_path / "log.csv", "timestamp,J1,J2", change(numbers(TIME, DEGREES)), ",")
    with pytest.raises(ValueError, match=said):
        read_log(file)


def test_files_that_are_no_logs_are_refused(tmp_path):
    for content in (b"", b"\0" * 100, b"no header\n1\n", b"a,a,timestamp\n"):
        (file := tmp_path / "x.csv").write_bytes(content)
        with pytest.raises(ValueError, match=r"x\.csv is no log"):
            read_log(file)
