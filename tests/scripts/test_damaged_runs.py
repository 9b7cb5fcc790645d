"""Runs whose files have been damaged: the file is named, in one line, with exit status 2."""

import json
import shutil
import zipfile

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

from .ran import ran

LEARN = "learn --plant two-mass --laws heuristic --iterations 1"
LASER = "laser --iterations 1"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for line in (LEARN, LASER):
        ran(folder / line.split()[0], line)
    return folder


@pytest.fixture(params=[LEARN, LASER], ids=lambda line: line.split()[0])
def damaged(request, runs, tmp_path):
    """A copy of a run, and the line that goes on from it."""
    name = request.param.split()[0]
    shutil.copytree(runs / name, tmp_path / "old")
    return tmp_path / "old", f"{name} --from old --iterations 1"


def change(folder, of):
    """Change one array of the state, by its name in the loop."""
    with np.load(folder / "state.npz") as stored:
        arrays = dict(stored)
    (tree,) = json.loads(str(arrays["tree"])).values()
    places = {name["plain"]: value.get("array") for name, value in tree["dict"]}
    for name, spoil in of.items():
        arrays[places[name]] = spoil(arrays[places[name]])
    np.savez(folder / "state.npz", **arrays)


def at_row(value):
    return lambda u: np.where(np.arange(len(u))[:, None] == 3, value, u)


WRONG = {
    "nan": ({"correction": at_row(np.nan)}, "correction must be finite, got nan at sample 3"),
    "complex": ({"correction": lambda u: u + 1j}, "correction must be real numbers, got complex"),
    "text": ({"error": lambda e: e.astype(str)}, "error must be real numbers, got <U"),
    "truth": ({"correction": lambda u: u > 0}, "correction must be real numbers, got bool"),
    "columns": (
        {name: lambda u: np.hstack((u, u)) for name in ("correction", "error", "first_size")},
        "the correction to resume from must have the shape",
    ),
    "one column": (
        {"error": lambda e: np.hstack((e, e))},
        "the error to resume from must have the shape",
    ),
    "flat": ({"correction": np.ravel}, "correction must have shape (N, n)"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_state_with_wrong_arrays_is_refused(damaged, bad_input, name):
    folder, line = damaged
    arrays, said = WRONG[name]
    change(folder, arrays)
    bad_input(line, said)


def test_a_state_that_unpacks_to_gigabytes_is_refused_before_it_does(damaged, bad_input):
    folder, line = damaged
    with zipfile.ZipFile(folder / "state.npz", "a") as packed:
        packed.writestr("array_9.npy", b"")
        packed.filelist[-1].file_size = 4_800_000_000
    bad_input(
        line,
        "state.npz holds no state of a learning run: unpacks to 4800 MB; at most 1000 MB are read",
    )


def test_a_seed_that_is_text_is_named_with_its_file(damaged, bad_input):
    folder, line = damaged
    file = folder / "summary.json"
    summary = json.loads(file.read_text())
    summary["config"]["seed"] = "seven"
    file.write_text(json.dumps(summary))
    bad_input(line, "old/summary.json: seed must be a whole number >= 0, got 'seven'")


EMPTY = {
    "laser": (
        "measure old",
        "laser --from old --speed 30",
        "export old --to csv --file u.csv",
        "replay old --save r.rrd",
        "commission --recordings old --out twin",
    ),
    "own": (
        "measure {} --gear 1",
        "calibrate-arm {} --robot ur10",
        "learn --plant two-mass --from {}",
        "export {} --to rsi --file u.rsi",
        "commission --recordings {} --out twin",
        "identify-plant {}",
    ),
}
COLUMNS = ("time", "reference_1", *(f"motor_angle_{i}" for i in range(1, 7)))
COLUMNS += ("target_1_x", "target_1_y", "target_1_z")


@pytest.mark.parametrize("line", EMPTY["laser"])
def test_an_empty_table_of_signals_is_named(runs, tmp_path, bad_input, line):
    shutil.copytree(runs / "laser", tmp_path / "old")
    file = tmp_path / "old" / "signals.parquet"
    pq.write_table(pq.read_table(file).slice(0, 0), file)
    assert "old" in bad_input(line, "row")


@pytest.mark.parametrize("columns", [COLUMNS, (), ("time", "correction_1")])
@pytest.mark.parametrize("line", EMPTY["own"])
def test_an_empty_table_of_own_data_is_named(tmp_path, bad_input, line, columns):
    none = pa.array([], pa.float64())
    pq.write_table(pa.table(dict.fromkeys(columns, none)), tmp_path / "mine.parquet")
    bad_input(line.format("mine.parquet"), "mine.parquet")


OUT = ("laser --out {}", "learn --plant two-mass --out {}", "robot model --out {}",
       "sweep gamma=0.5 --into {}", "measure {run} --out {}", "imu --out {}")  # fmt: skip


@pytest.mark.parametrize("name", ["round", "round/x"])
@pytest.mark.parametrize("line", OUT)
def test_a_loop_of_links_is_named(runs, tmp_path, bad_input, line, name):
    (tmp_path / "round").symlink_to("back")
    (tmp_path / "back").symlink_to("round")
    bad_input(line.format(name, run=runs / "laser"), f"{name} is a loop of links")


def test_a_backend_that_is_none_is_named_before_any_work(armside_process, monkeypatch, tmp_path):
    monkeypatch.setenv("MPLBACKEND", "nonsense")
    done = armside_process("probe --out out")
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert "MPLBACKEND names 'nonsense', which is no backend of matplotlib" in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("spoilt", ["hello", np.array([[1, "a"]], object), np.ones((2, 3, 4))])
def test_a_record_that_is_none_is_named_with_its_file(tmp_path, bad_input, spoilt):
    savemat(tmp_path / "m.mat", {"u": spoilt, "y": np.eye(9)[:, :1], "sample_time": 0.1})
    bad_input("identify-plant m.mat", "m.mat: u must ")
