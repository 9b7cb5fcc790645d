"""`armside replay` from the command line: what is saved, and one line for bad input."""

import json
import shutil
import socket
import subprocess

import numpy as np
import pyarrow.parquet as pq
import pytest

from armside.scripts import cli
from armside.scripts.viewers import web_viewer
from armside.sim.replay.run_scene import about, learning

from .ran import ran
from .replay_content import content


@pytest.fixture(scope="module")
def run(replayed):
    return replayed / "two"


@pytest.fixture(scope="module")
def file(replayed):
    return replayed / "two.rrd"


@pytest.fixture
def no_display(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def entities(file):
    from rerun.chunk import RrdReader

    return {chunk.entity_path for chunk in RrdReader(file).stream().to_chunks()}


def test_rerun_accepts_what_is_saved(file):
    done = subprocess.run([web_viewer.rerun_program(), "rrd", "verify", str(file)], check=False)
    assert done.returncode == 0


def test_the_run_leaves_the_same_replay_as_the_command_draws(run, file):
    """Shapes of the robot are those of its written model, which is rounded by 0.1 um."""
    left, drawn = content(run / "replay.rrd"), content(file)
    assert left.keys() == drawn.keys()
    assert {entity for entity in left if left[entity] != drawn[entity]} <= {
        entity for entity in left if entity.startswith("/robot/")
    }


def test_every_kind_of_signal_is_there(file):
    expected = "about arm_error motor_error correction motor_torque tracker imu/acceleration"
    expected += " imu/angular_velocity spectrum/tool spectrum/motors learning/tool_RMS"
    expected += " learning/motor_6 paths/tool plane/tool robot/tool/box"
    assert {f"/{name}" for name in expected.split()} <= entities(file)


def test_runs_side_by_side_are_told_apart(run, tmp_path):
    other = shutil.copytree(run, tmp_path / "other")
    both = tmp_path / "both.rrd"
    assert cli.main(["replay", str(run), str(other), "--save", str(both), "--quiet"]) == 0
    found = entities(both)
    assert {"/two/paths/tool", "/other/paths/tool"} <= found
    assert "/paths/tool" not in found


def test_magnification_is_that_asked_for(run, tmp_path):
    spread, contents = [], []
    for factor in ("1", "3"):
        file = tmp_path / f"{factor}.rrd"
        line = f"replay {run} --save {file} --magnification {factor} --quiet"
        assert cli.main(line.split()) == 0
        spread.append(deviation_in_plane(file))
        contents.append(content(file))
    other = {entity for entity, rows in contents[0].items() if rows != contents[1][entity]}
    assert {entity.split("/")[1] for entity in other} >= {"plane"}
    assert "/tracker" not in other
    assert spread[1] == pytest.approx(3 * spread[0], rel=1e-3)


def deviation_in_plane(file):
    """Largest distance of the first run's tool from the circle of 5 mm."""
    from rerun.chunk import RrdReader

    for chunk in RrdReader(file).stream().to_chunks():
        if chunk.entity_path == "/plane/tool" and not chunk.is_static:
            strips = chunk.to_record_batch().column("LineStrips2D:strips")[0].as_py()
            return np.abs(np.linalg.norm(strips[0], axis=1) - 5.0).max()
    raise AssertionError("no tool path")


def test_text_and_curves_say_what_the_summary_says(run):
    summary = json.loads((run / "summary.json").read_text())
    first, last = summary["iterations"][0], summary["iterations"][-1]
    text = about(summary)
    assert f"| {1e6 * last['arm_rms']:.0f} |" in text
    assert "**cutoff** 10 Hz" in text
    curves = learning(summary["iterations"])
    assert curves["tool RMS"] == [1.0, last["arm_rms"] / first["arm_rms"]]
    assert curves["motor 3"][1] == last["motor_two"][2] / first["motor_two"][2]


def test_a_lost_beam_is_a_gap_in_the_curves():
    row = {"motor_two": [1.0] * 6, "arm_rms": None, "arm_maxdev": None}
    assert np.isnan(learning([row])["tool RMS"]).all()


@pytest.fixture
def refused(bad_input):
    def check(*words):
        return bad_input(" ".join(map(str, ["replay", *words])), "")

    return check


def test_no_display_is_said_with_what_else_works(run, refused, no_display):
    assert "--web" in refused(run)


def test_a_folder_that_is_no_run_is_refused(tmp_path, refused, run):
    assert "no summary.json" in refused(tmp_path, "--web")
    assert "is no folder" in refused(tmp_path / "missing", "--web")
    assert "give the folder" in refused("--web")
    assert "twice" in refused(run, run, "--web")


def test_a_run_of_another_format_is_refused_by_number(run, tmp_path, refused):
    old = shutil.copytree(run, tmp_path / "old")
    summary = json.loads((old / "summary.json").read_text())
    del summary["format"]
    (old / "summary.json").write_text(json.dumps(summary))
    assert "format 0, this one reads 1" in refused(old, "--web")
    (old / "summary.json").write_text("[]")
    assert "no summary" in refused(old, "--web")
    (old / "summary.json").write_text("{")
    assert "cannot be read" in refused(old, "--web")


def test_signals_of_another_format_are_refused_by_number(run, tmp_path, refused):
    old = shutil.copytree(run, tmp_path / "old")
    table = pq.read_table(old / "signals.parquet")
    metadata = {**table.schema.metadata, b"armside.format": b"99"}
    pq.write_table(table.replace_schema_metadata(metadata), old / "signals.parquet")
    assert "format 99; this armside reads 1" in refused(old, "--save", tmp_path / "r.rrd")


def test_a_port_in_use_is_one_line(run, refused):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert f"port {port} is in use" in refused(run, "--web", "--port", port)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--magnification 0 --web", "--magnification. Must be > 0"),
        ("--port 70000 --web", "port"),
        ("--save replay.txt", ".rrd"),
        ("--save missing/replay.rrd", "missing is no folder"),
        ("--png p.jpg", ".png"),
        ("--video film.avi", ".gif"),
    ],
)
def test_bad_options_are_refused(words, said, run, refused):
    assert said in refused(run, *words.split())


def test_an_experiment_without_motion_has_no_replay(tmp_path, refused):
    ran(tmp_path / "rest", "imu --motion rest --off 3 --on 3")
    assert "no replay" in refused(tmp_path / "rest", "--save", tmp_path / "r.rrd")


def test_six_runs_are_small(tmp_path):
    ran(tmp_path / "six", "laser")
    assert (tmp_path / "six" / "replay.rrd").stat().st_size < 10e6
