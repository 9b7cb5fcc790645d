"""Data out and back: other tools' files hold the run, and measure as the run did."""

import json
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from armside.scripts import cli
from armside.sim.records.tables import read_table, units, write_table

from .ran import ran


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "one"
    ran(out, "laser --iterations 1")
    return out


def measured(file, capsys, *words):
    assert cli.main(["measure", str(file), "--json", *words]) == 0
    return json.loads(capsys.readouterr().out)["iterations"]


@pytest.mark.parametrize("kind", ["csv", "mat", "hdf5"])
def test_a_run_read_back_is_the_run_bit_for_bit_and_measures_the_same(run, tmp_path, kind, capsys):
    file = tmp_path / f"signals.{kind}"
    words = ["convert", str(run), "--to", kind, "--file", str(file), "--quiet"]
    assert cli.main(words) == 0
    written, back = pq.read_table(run / "signals.parquet"), read_table(file)
    assert back.column_names == written.column_names
    assert units(back) == units(written)
    for name in written.column_names:
        assert same(back[name], written[name]), name
    rows = measured(file, capsys)
    assert measured(run, capsys) == rows
    for row, original in zip(
        rows, json.loads((run / "summary.json").read_text())["iterations"], strict=True
    ):
        for name in row:
            assert row[name] == original[name], name


def same(a, b):
    """Same nulls, same bits; NaN equals NaN."""
    a, b = a.combine_chunks(), b.combine_chunks()
    if a.type != b.type or a.is_null().to_pylist() != b.is_null().to_pylist():
        return False
    x, y = (c.drop_null().to_numpy(zero_copy_only=False) for c in (a, b))
    return x.tobytes() == y.tobytes()


def test_joints_that_are_given_twice_are_bad_input(run, bad_input):
    bad_input(f"convert {run} --joints a b a", "armside: a is given twice\n")


def test_a_lost_beam_survives_files_without_missing_values(tmp_path):
    table = pa.table(
        {
            "k": pa.array([0, 0, 0], pa.int32()),
            "time": [0.0, 0.1, 0.2],
            "tracker_x": [1.0, np.nan, None],
            "tracker_valid": [True, False, None],
        }
    )
    for kind in ("csv", "mat", "h5"):
        write_table(tmp_path / f"t.{kind}", table)
        back = read_table(tmp_path / f"t.{kind}")
        assert back["tracker_valid"].to_pylist() == [True, False, None]
        assert np.isnan(back["tracker_x"][1].as_py())
        assert back["tracker_x"][2].as_py() is None


def test_mcap_holds_every_sample_of_the_log(run, tmp_path):
    from mcap.reader import make_reader

    file = tmp_path / "s.mcap"
    words = ["convert", str(run), "--to", "mcap", "--file", str(file), "--quiet"]
    assert cli.main(words) == 0
    table = pq.read_table(run / "signals.parquet")
    with file.open("rb") as opened:
        messages = [
            (message.log_time, json.loads(message.data))
            for _, _, message in make_reader(opened).iter_messages(topics="/log")
        ]
    logged = table.filter(table["reference_1"].is_valid())
    assert len(messages) == logged.num_rows
    assert [m["motor_angle_4"] for _, m in messages] == logged["motor_angle_4"].to_pylist()
    assert [m["k"] for _, m in messages] == logged["k"].to_pylist()


def test_octave_reads_the_matlab_file(run, tmp_path, require_program):
    import subprocess

    octave = require_program("octave-cli")
    file = tmp_path / "s.mat"
    words = ["convert", str(run), "--to", "mat", "--file", str(file), "--quiet"]
    assert cli.main(words) == 0
    code = f"load('{file}'); printf('%.17g', max(abs(reference_1 - motor_angle_1)(k == 0)))"
    said = subprocess.run(
        [octave, "--no-init-file", "--eval", code], capture_output=True, text=True, check=True
    )
    worst = json.loads((run / "summary.json").read_text())["iterations"][0]["motor_inf"][0]
    assert float(said.stdout) * 220 == pytest.approx(worst, rel=1e-12)


# Own recorded data


def own_data(radius=0.005, excess=20e-6):
    """Two motors, a tracker on a circle that is a bit too large."""
    time = np.arange(500) * 0.004
    angle = np.pi * time
    turn = np.column_stack([np.cos(angle), np.sin(angle)]) * (radius + excess)
    reference = np.column_stack([np.sin(time), np.cos(time)])
    error = np.array([1e-3, -2e-3])
    return pa.table(
        {
            "time": time,
            "reference_1": reference[:, 0],
            "reference_2": reference[:, 1],
            "motor_angle_1": reference[:, 0] - error[0],
            "motor_angle_2": reference[:, 1] - error[1],
            "tracker_x": 0.3 + turn[:, 0],
            "tracker_y": turn[:, 1],
            "tracker_z": np.full(500, 1.2),
        }
    )


@pytest.mark.parametrize("suffix", [".csv", ".mat", ".h5", ".parquet"])
def test_own_data_get_the_same_analysis(tmp_path, capsys, suffix):
    file = tmp_path / f"mine{suffix}"
    write_table(file, own_data())
    (row,) = measured(file, capsys, "--gear", "100", "50", "--radius", "5")
    assert row["motor_inf"] == pytest.approx([0.1, 0.1])
    assert row["motor_two"] == pytest.approx([0.1 * np.sqrt(500)] * 2)
    assert row["arm_rms"] == pytest.approx(20e-6, rel=1e-9)
    assert row["arm_maxdev"] == pytest.approx(20e-6, rel=1e-9)


def test_only_the_turn_asked_for_is_measured(tmp_path, capsys):
    file = tmp_path / "mine.csv"
    write_table(file, column("tracker_x", lambda x: x + 1.0 * (np.arange(500) < 100))(own_data()))
    (row,) = measured(file, capsys, "--gear", "1", "1", "--radius", "5", "--start", "0.4")
    assert row["arm_rms"] == pytest.approx(20e-6, rel=1e-9)


def test_without_a_radius_only_motors_are_measured(tmp_path, capsys):
    write_table(tmp_path / "mine.csv", own_data())
    (row,) = measured(tmp_path / "mine.csv", capsys, "--gear", "1", "1")
    assert row["arm_rms"] is None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("measure missing.csv", "missing.csv"),
        ("measure mine.csv", "the data have 2 motors and the robot large has 6: give --gear"),
        ("measure mine.csv --gear 1 1 1", "columns are missing: reference_3"),
        ("measure mine.csv --gear 1", "more motors than the 1 gears"),
        ("measure mine.csv --gear 1 0", "gear must be in (0, 1e+06], got 0"),
        ("measure mine.csv --radius 0", "radius must be in (0, 5000] mm, got 0"),
        ("measure words.csv --gear 1", "numbers are needed, got"),
        ("measure mine.xls", ".parquet, .csv, .mat"),
        ("convert .", "no summary.json"),
    ],
)
def test_bad_input_is_one_clear_line(words, said, tmp_path, monkeypatch, bad_input):
    monkeypatch.chdir(tmp_path)
    write_table(Path("mine.csv"), own_data())
    Path("words.csv").write_text("time,reference_1,motor_angle_1\nsoon,far,off\n")
    Path("mine.xls").write_text("")
    bad_input(words, said)


def column(name, change):
    def spoil(table):
        values = pa.array(change(table[name].to_numpy()))
        return table.set_column(table.column_names.index(name), name, values)

    return spoil


def at(row, value):
    return lambda t: [value if i == row else x for i, x in enumerate(t.tolist())]


def words(time):
    return ["soon" if i == 4 else repr(float(t)) for i, t in enumerate(time)]


def degrees(table):
    for name in ("reference_1", "reference_2", "motor_angle_1", "motor_angle_2"):
        table = column(name, np.degrees)(table)
    return table


SPOILT = {
    "null": (column("time", at(4, None)), "column time, row 5: must be a time [s], got nan"),
    "text": (column("time", words), "column time, row 5: numbers are needed, got 'soon'"),
    "reversed": (column("time", np.flip), "row 2: time must increase, got 1.992 s after 1.996 s"),
    "constant": (column("time", np.zeros_like), "row 2: time must increase, got 0 s after 0 s"),
    "milliseconds": (column("time", lambda t: 1e3 * t), "are they in milliseconds?"),
    "a hole": (
        column("time", lambda t: t + 5.0 * (t > 1)),
        "row 251: no samples for 5 s after 1 s",
    ),
    "degrees": (
        degrees,
        "reference_2 reaches 57.3, its limit is 12.6 rad; are the angles in degrees",
    ),
}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("name", SPOILT)
def test_data_with_wrong_times_or_units_are_not_measured(name, suffix, tmp_path, bad_input):
    spoil, said = SPOILT[name]
    file = tmp_path / f"mine{suffix}"
    write_table(file, spoil(own_data()))
    bad_input(f"measure {file} --gear 100 50 --radius 5", said)


OF_TIME = ("reversed", "constant", "milliseconds", "a hole", "text")
STORED = {name: SPOILT[name][0] for name in OF_TIME}
STORED |= {"degrees": column("motor_angle_2", np.degrees)}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("name", STORED)
def test_signals_with_wrong_times_or_units_are_not_measured(run, name, suffix, tmp_path, bad_input):
    file = tmp_path / f"spoilt{suffix}"
    write_table(file, STORED[name](read_table(run / "signals.parquet")))
    said = "motor_angle_2 reaches" if name == "degrees" else "column time, row"
    assert file.name in bad_input(f"measure {file}", said)


def test_angles_of_motor_shafts_may_turn_without_bound(tmp_path, capsys):
    write_table(tmp_path / "mine.csv", degrees(own_data()))
    measured(tmp_path / "mine.csv", capsys, "--gear", "1", "1")


def test_a_missing_package_is_named_with_its_extra(run, monkeypatch, bad_input):
    monkeypatch.setitem(sys.modules, "h5py", None)
    bad_input(f"convert {run} --to hdf5 --file s.h5", "armside[convert]")
