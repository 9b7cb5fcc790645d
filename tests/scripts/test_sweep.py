"""`armside sweep`: what is asked for is there once, and what went wrong is said."""

import json
import shutil
import sys

import pyarrow.parquet as pq
import pytest

from armside.scripts.cutting.cut_run import run
from armside.scripts.cutting.options import LaserCfg
from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import parse
from armside.scripts.jobs.queue import Claims
from armside.scripts.shell.errors import InputError

from .sweep_engine import Serial, failing_with, quick, start


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ((), "at least one axis"),
        (("gamma",), "option=value,value"),
        (("gama=1",), "Unknown option of laser 'gama'. Did you mean gamma?"),
        (("gamma=1,-1",), "gamma=-1: gamma must be > 0"),
        (("gamma=1,",), "gamma=: gamma takes one value or six, got 0"),
        (("speed=40,",), "speed has an empty value"),
        (("contour=",), "contour has an empty value"),
        (("pose=p1,p9",), "pose=p9: Unknown pose 'p9'"),
        (("shape=circle,square", "radius=8"), "shape=square: a square has no radius"),
        (("gamma=1,2", "shape=square", "radius=8"), "no configuration of the grid can be run"),
        (("law=inverse", "gamma=1,2"), "law=inverse: law inverse needs --measure"),
        (("law=inverse", "measure=estimate", "cutoff=-1"), "cutoff=-1: cutoff must be above 0"),
        (("position=1/2",), "position=1/2: Incorrect number"),
        (("contour=a/missing.toml",), "missing.toml: .* No such file"),
        (("seed=-1,0",), r"seed=-1: seed must be 0 to 9.22337e\+18"),
        (("gamma=1", "gamma=2"), "gamma is given twice"),
        (("delta=3,3",), "has a value twice"),
        (("delta=1.5",), "must be a whole number"),
        (("seed=3:3",), "has no values"),
        (("robot=r2d2",), "robot=r2d2"),
    ],
)
def test_an_axis_that_makes_no_sense_is_refused(axes, message):
    with pytest.raises(InputError, match=message.replace("?", r"\?")):
        parse(axes, 0)


def test_the_engine_is_asked_before_the_grid_is_built(armside, monkeypatch):
    monkeypatch.setattr(
        "armside.scripts.commands.sweep.parse", lambda *_: pytest.fail("built a grid")
    )
    status, _, err = armside("sweep gamma=1 --engine ray --address 127.0.0.1:1")
    assert (status, "Ray" in err) == (2, True)


def test_without_ray_the_extra_is_named(bad_input, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    said = "armside: the engine ray needs Ray: pip install 'armside[cluster]'\n"
    bad_input("sweep gamma=1 --engine ray --address 127.0.0.1:1", said)


def test_rows_are_what_armside_laser_finds(whole):
    (row,) = [
        row
        for row in whole.to_pylist()
        if (row["gamma"], row["pose"], row["seed"]) == ([0.9], "p1", 1)
    ]
    place = (1316.6, 1.4, 1599.2)
    found = run(LaserCfg(speed=60.0, iterations=1, position=place), 1)
    assert row["arm_rms"] == [it["arm_rms"] for it in found["iterations"]]
    assert row["motor_two"] == [it["motor_two"].tolist() for it in found["iterations"]]
    assert row["notes"] == [note.line for note in found["notes"]]
    assert (row["status"], row["error"]) == ("done", None)


def test_a_configuration_that_fails_is_recorded_with_its_error(whole):
    rows = [row for row in whole.to_pylist() if row["position"][0] == 9000.0]
    assert len(rows) == 4
    for row in rows:
        assert row["status"] == "failed"
        assert "out of reach" in row["error"]
        assert row["arm_rms"] is None


def test_failed_configurations_end_in_status_1_with_the_first_error(armside, monkeypatch):
    unlucky = failing_with("no luck with 2", "no luck with 3")
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(unlucky))
    status, out, err = armside("sweep delta=1:4 --into there --json")
    assert (status, err.count("\n")) == (1, 1)
    assert "2 of 3 configurations failed, the first with no luck with 2" in err
    assert "--retry-failed" in err
    assert json.loads(out)["status"] == "failed"
    status, out, err = armside("sweep delta=1:4 --into there")
    assert (status, "no luck with 2" in err) == (1, True)
    assert "3 configurations: 1 known, 2 known (failed)" in out
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(quick))
    status, out, err = armside("sweep delta=1:4 --into there --retry-failed")
    assert (status, err) == (0, "")
    assert "2 done, 1 known" in out


def noted(point):
    (delta,) = point.options["delta"]
    return quick(point) | {"notes": ["the speed is lowered"] if delta > 1 else []}


def test_limits_are_counted_at_the_end_and_noted_in_the_rows(armside, tmp_path, monkeypatch):
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(noted))
    _, out, _ = armside("sweep delta=1:4 --into there")
    said = "Note: limits changed 2 of them (column notes), mostly: the speed is lowered\n"
    assert said in out
    _, out, _ = armside("sweep delta=1:4 --into there --json")
    assert json.loads(out)["notes"] == [{"text": "the speed is lowered", "configurations": 2}]
    assert sorted(map(len, Dataset(tmp_path / "there").read()["notes"].to_pylist())) == [0, 1, 1]
    _, out, _ = armside("sweep delta=1 --into there")
    assert "Note" not in out


def test_a_dataset_of_before_notes_is_read_and_added_to(armside, tmp_path, monkeypatch):
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(noted))
    assert armside("sweep delta=1:4 --into there").status == 0
    (part,) = (tmp_path / "there").glob("part-*")
    pq.write_table(pq.read_table(part).drop_columns(["notes"]), part.with_name("part-ab.parquet"))
    part.unlink()
    shutil.rmtree(tmp_path / "there" / ".rows")  # which that version had none of
    status, out, _ = armside("sweep delta=1:5 --into there")
    assert (status, "1 done, 3 known" in out) == (0, True)
    assert "limits changed 1 of them" in out


def test_ctrl_c_says_what_is_kept(armside, tmp_path, monkeypatch):
    def stop_at_3(point):
        if point.options["delta"] == (3,):
            raise KeyboardInterrupt
        return quick(point)

    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(stop_at_3))
    status, _, err = armside("sweep delta=3 --into there")
    assert (status, err) == (130, "armside: interrupted, nothing was kept\n")
    status, _, err = armside("sweep delta=1:9 --into there")
    kept = len(Dataset(tmp_path / "there").read())
    assert 0 < kept < 8
    assert status == 130
    assert f"{kept} of 8 configurations are kept in there, repeat the command to go on" in err


def test_who_can_only_wait_for_others_says_so_once(tmp_path, armside, monkeypatch):
    keys = [point.key for point in parse(("delta=1:4",), 0)]
    theirs, looks = Claims(tmp_path / "there"), []
    assert theirs.take(keys[1])
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(quick))

    def sleep(_):
        looks.append(None)
        if len(looks) == 3:
            theirs.drop()

    monkeypatch.setattr("armside.scripts.jobs.queue.time.sleep", sleep)
    status, _, err = armside("sweep delta=1:4 --into there")
    said = "armside: waiting for 1 configurations that another sweep has claimed\n"
    assert (status, err, len(looks)) == (0, said, 3)


def test_two_sweeps_into_one_folder_share_the_work(tmp_path, whole):
    both = [start(tmp_path) for _ in range(2)]
    assert [process.wait(120) for process in both] == [1, 1]  # half of it cannot be done
    assert Dataset(tmp_path).read().equals(whole)
