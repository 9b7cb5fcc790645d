"""Grids of a sweep: options, axes, and one key for each configuration."""

import json
from pathlib import Path

import pytest

from armside import assets
from armside.scripts.jobs import resolved
from armside.scripts.jobs.grid import Grid, parse
from armside.scripts.jobs.resolved import key_of

from .sweep_engine import failed


def test_a_grid_is_every_combination_under_one_key_each():
    grid = parse(("gamma=0.5,0.9", "delta=3,6,9", "seed=2:5"), 0)
    points = list(grid)
    assert len(points) == len(grid) == 18
    assert len({point.key for point in points}) == 18
    assert points[0].options == {"gamma": (0.5,), "delta": (3,)}
    assert [point.seed for point in points[:3]] == [2, 3, 4]


def test_a_key_is_that_of_the_whole_configuration():
    assert key_of({"gamma": (0.9,)}, 0) == key_of({}, 0)  # the default
    assert key_of({"gamma": (0.8,)}, 0) != key_of({}, 0)
    assert key_of({}, 1) != key_of({}, 0)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({}, {"law": "heuristic", "payload": 40.0}),
        ({}, {"gamma": (0.9,) * 6, "delta": (3,) * 6}),
        ({}, {"stiffness_error": 10.0, "on_imu_fault": "go-on"}),
        ({}, {"position": (1316.6, 1.4, 1599.2), "pose": "p2"}),
        ({"measure": "estimate"}, {"measure": "estimate", "law": "inverse", "cutoff": (13.0,)}),
        ({"robot": "irb1400"}, {"robot": "irb1400", "cutoff": (20.0,)}),
        ({"shape": "square"}, {"shape": "square", "size": 20.0, "corner": 3.0}),
        ({"shape": "slot", "size": 24.0}, {"shape": "slot", "size": 24.0, "width": 8.0}),
    ],
)
def test_options_that_come_to_the_same_run_have_the_same_key(one, other):
    assert key_of(one, 0) == key_of(other, 0)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        # The default cutoff is 14 Hz there.
        ({"measure": "estimate", "speed": 110.0}, {"cutoff": (10.0,)}),
        ({"measure": "estimate"}, {"stiffness_error": 10.0}),
        ({}, {"position": (1316.6, 1.4, 1599.3)}),
        ({}, {"payload": 41.0}),
        ({}, {"measure": "tracker"}),
        ({"robot": "irb1400"}, {"cutoff": (10.0,)}),
    ],
)
def test_options_that_come_to_different_runs_have_different_keys(one, other):
    assert key_of(one, 0) != key_of(one | other, 0)


def test_a_point_is_there_once_however_often_its_grid_says_it():
    grid = parse(("law=auto,heuristic", "gamma=0.9,0.9/0.9/0.9/0.9/0.9/0.9", "seed=0:2"), 0)
    assert len(grid) == 8
    assert [point.seed for point in grid] == [0, 1]


def test_a_row_has_the_options_that_were_run():
    (fast,) = parse(("measure=estimate", "speed=110"), 0)
    row = failed(fast, "not run")
    assert row["cutoff"] == pytest.approx([440.0 / (10.0 * 3.141592653589793)])
    assert (row["law"], row["gamma"], row["payload"]) == ("inverse", [0.9], 40.0)
    assert (row["pose"], row["position"]) == ("p1", [1316.6, 1.4, 1599.2])
    (square,) = parse(("shape=square", "position=1500/0/1599.2"), 0)
    row = failed(square, "not run")
    assert (row["size"], row["corner"], row["radius"]) == (20.0, 3.0, None)
    assert (row["pose"], row["law"]) == (None, "heuristic")


CONTOUR = "points = [[-10, -6], [10, -6], [10, {top}], [-10, 6]]\n"


SCENE = '<mujoco><include file="{robot}"/></mujoco>'


def _write_contour(folder, changed):
    file = folder / "part.toml"
    file.write_text(CONTOUR.format(top=7 if changed else 6))
    return {"contour": file}


def _write_model(folder, changed):
    robot = Path(assets.LARGE_ROBOT_XML).read_text()
    (folder / "robot.xml").write_text(robot + "<!-- -->" if changed else robot)
    (folder / "scene.xml").write_text(SCENE.format(robot="robot.xml"))
    return {"model": folder / "scene.xml"}


def _write_identification(folder, changed):
    (folder / "summary.json").write_text(json.dumps({"springs": changed}))
    return {"identification": folder, "measure": "estimate"}


@pytest.mark.parametrize("write", [_write_contour, _write_model, _write_identification])
def test_a_file_with_another_content_is_another_configuration_wherever_it_is(tmp_path, write):
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    key = key_of(write(here, False), 0)
    assert key_of(write(there, False), 0) == key
    assert key_of(write(here, True), 0) != key


def test_a_file_that_changes_while_a_sweep_runs_leaves_no_result_under_the_old_key(tmp_path):
    cut = _write_contour(tmp_path, changed=False) | {"iterations": 0}
    (point,) = Grid({name: (value,) for name, value in cut.items()} | {"seed": (0,)})
    assert point.run()["status"] == "done"
    _write_contour(tmp_path, changed=True)
    row = point.run()
    assert (row["status"], "not what it was" in row["error"]) == ("failed", True)


def test_a_value_is_checked_beside_those_of_the_other_axes():
    (point,) = parse(("law=norm-optimal", "measure=estimate"), 0)
    assert point.options == {"law": "norm-optimal", "measure": "estimate"}
    assert len(list(parse(("law=auto,inverse", "measure=motor,estimate"), 0))) == 3


def test_only_options_of_several_values_are_split_and_may_be_empty(tmp_path):
    file = _write_contour(tmp_path, changed=False)["contour"]
    (point,) = parse((f"contour={file}",), 0)
    assert point.options == {"contour": file}
    none, two = parse(("without=,ripple/gear-error",), 0)
    assert none.options == {"without": ()}
    assert two.options == {"without": ("ripple", "gear-error")}


def test_a_relative_path_is_the_same_file_for_workers_elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(_write_contour(tmp_path, changed=False)["contour"].parent)
    (point,) = parse(("contour=part.toml",), 0)
    assert point.options == {"contour": tmp_path / "part.toml"}


def _counted(monkeypatch, name):
    """Calls of a function of `resolved` from now on."""
    calls, function = [], getattr(resolved, name)

    def noted(*args, **options):
        calls.append(args)
        return function(*args, **options)

    monkeypatch.setattr(resolved, name, noted)
    return calls


def test_each_configuration_of_a_grid_is_resolved_once_whatever_its_seeds(monkeypatch):
    calls = _counted(monkeypatch, "LaserCfg")
    points = list(parse(("gamma=0.1,0.2,0.3,0.4", "seed=0:50"), 0))
    assert len(points) == 200
    assert len(calls) == 4


def test_each_file_of_a_grid_is_hashed_once(monkeypatch, tmp_path):
    calls = _counted(monkeypatch, "content_of")
    files = []
    for name in "ab":
        (tmp_path / name).mkdir()
        files.append(_write_contour(tmp_path / name, changed=name == "b")["contour"])
    points = list(parse((f"contour={files[0]},{files[1]}", "gamma=0.1,0.2,0.3", "seed=0:9"), 0))
    assert len(points) == 54
    assert sorted(calls) == [("contour", file) for file in files]


def test_values_of_six_motors_and_options_with_dashes_are_read():
    grid = parse(("gamma=0.9/0.9/0.8/0.8/0.7/0.7", "friction-spread=1,2"), 0)
    first = next(iter(grid))
    assert first.options == {"gamma": (0.9, 0.9, 0.8, 0.8, 0.7, 0.7), "friction_spread": 1.0}
