"""`armside replay` as its users meet it: viewer, browser, files, and one line for bad input."""

import http.client
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading

import numpy as np
import pyarrow.parquet as pq
import pytest
from PIL import Image

from armside.scripts import cli
from armside.scripts.viewers import web_viewer
from armside.scripts.viewers.replay_scene import about, learning


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "two"
    assert cli.main(["laser", "--iterations", "1", "--quiet", "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def file(run):
    file = run.parent / "two.rrd"
    assert cli.main(["replay", str(run), "--save", str(file), "--quiet"]) == 0
    return file


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
    assert entities(run / "replay.rrd") == entities(file)


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
    spread = []
    for factor in ("1", "3"):
        file = tmp_path / f"{factor}.rrd"
        words = ["replay", str(run), "--save", str(file), "--magnification", factor, "--quiet"]
        assert cli.main(words) == 0
        spread.append(deviation_in_plane(file))
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


# The web viewer


@pytest.fixture(scope="module")
def viewer(file):
    viewer = web_viewer.WebViewer(file, port=0)
    thread = threading.Thread(target=viewer.serve)
    thread.start()
    yield viewer
    viewer.close()
    thread.join()


def ask(viewer, path, host=None):
    port = int(viewer.address.rstrip("/").rpartition(":")[2])
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request("GET", path, headers={"Host": host or f"127.0.0.1:{port}"})
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer, content


def test_the_page_may_talk_to_nobody_else(viewer):
    answer, page = ask(viewer, "/?url=x")
    policy = answer.headers["Content-Security-Policy"]
    assert "connect-src 'self'" in policy
    assert "http" not in policy
    assert b"fonts.googleapis.com" in page  # so that the policy has something to forbid


def test_the_replay_is_served_as_written(viewer, file):
    _, content = ask(viewer, "/replay.rrd")
    assert content == file.read_bytes()


def test_another_name_for_this_machine_is_refused(viewer):
    answer, _ = ask(viewer, "/replay.rrd", host="evil.example")
    assert answer.status == 403


def test_other_machines_do_not_reach_it(viewer):
    assert viewer.address.startswith("http://127.0.0.1:")
    assert viewer._server.server_address[0] == "127.0.0.1"


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_the_web_viewer_cleanly(run, ending):
    command = [
        sys.executable,
        "-m",
        "armside.scripts.cli",
        "replay",
        str(run),
        "--web",
        "--port",
        "0",
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    line = process.stdout.readline()
    address = re.search(r"http://127\.0\.0\.1:(\d+)/", line)
    assert address, line
    process.send_signal(ending)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 0
    assert err == ""
    with socket.socket() as free:
        assert free.connect_ex(("127.0.0.1", int(address[1]))) != 0


def test_statistics_are_off_unless_asked_for(tmp_path):
    with web_viewer.private_environment(telemetry=False) as env:
        said = subprocess.run(
            [web_viewer.rerun_program(), "analytics", "config"],
            env=env,
            capture_output=True,
            text=True,
            check=True,
        )
    assert re.search(r'"?analytics_enabled"?:\s*false', said.stdout + said.stderr)
    with web_viewer.private_environment(telemetry=True) as env:
        assert env == dict(os.environ)


def colours(png, box):
    """Pixels of each clearly coloured kind in a part of the page, by name."""
    import io

    image = np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
    height, width, _ = image.shape
    x0, y0, x1, y1 = box
    part = image[int(y0 * height) : int(y1 * height), int(x0 * width) : int(x1 * width)]
    r, g, b = part[..., 0], part[..., 1], part[..., 2]
    return {
        "orange": int(((r > 150) & (b < 90) & (r - g > 60)).sum()),
        "blue": int(((b > 150) & (b - r > 90)).sum()),
        "green": int(((g > 120) & (g - r > 90)).sum()),
    }


# Parts of the page: left, top, right, bottom.
ROBOT = (0.0, 0.08, 0.29, 0.58)
PATHS = (0.3, 0.08, 0.64, 0.58)
MOTOR_ERROR = (0.66, 0.08, 0.95, 0.34)
DEVIATION = (0.66, 0.39, 0.95, 0.64)


def looks_full(png):
    return (
        colours(png, ROBOT)["orange"] > 2000
        and colours(png, PATHS)["orange"] > 200
        and colours(png, PATHS)["blue"] > 200
        and colours(png, MOTOR_ERROR)["green"] > 100
        and colours(png, DEVIATION)["orange"] > 100
    )


def test_chromium_shows_robot_and_plots_and_asks_nobody_else(viewer, require_program):
    require_program("chromium", "google-chrome")
    driver = require_program("chromedriver")
    from armside.scripts.viewers.browser import page

    with page(f"{viewer.address}?renderer=webgl", driver=driver) as shown:
        png = shown.screenshot_when(looks_full, within=60)
        answered = {url for url in shown.answered() if not url.startswith(("data:", "blob:"))}
    assert looks_full(png), {box: colours(png, box) for box in (ROBOT, PATHS, MOTOR_ERROR)}
    assert all(url.startswith(viewer.address) for url in answered), answered
    assert any(url.endswith("/replay.rrd") for url in answered)


# Pictures without a window


def test_a_picture_shows_the_robot_and_its_path(run, tmp_path, graphics):
    png = tmp_path / "p.png"
    assert cli.main(["replay", str(run), "--png", str(png), "--quiet"]) == 0
    left, right = (0.0, 0.0, 0.57, 1.0), (0.58, 0.1, 1.0, 0.9)
    assert colours(png.read_bytes(), left)["orange"] > 10_000
    assert colours(png.read_bytes(), right)["blue"] > 500


def test_a_film_shows_every_run_in_real_time(run, tmp_path, graphics, monkeypatch):
    from armside.sim.replay import film

    monkeypatch.setattr(film, "RATE", 2.0)
    monkeypatch.setattr(film, "WIDTH", 160)
    monkeypatch.setattr(film, "HEIGHT", 120)
    file = tmp_path / "film.gif"
    assert cli.main(["replay", str(run), "--video", str(file), "--quiet"]) == 0
    time = pq.read_table(run / "signals.parquet", columns=["time"])["time"].to_numpy().max()
    with Image.open(file) as image:
        assert 2 * time - 1 <= image.n_frames / 2 <= 2 * time + 1
        assert image.info["duration"] == 500


def test_without_opengl_it_says_what_is_missing(run, tmp_path, monkeypatch, capsys):
    import mujoco.egl

    def refuse(*_):
        raise ImportError("no libEGL.so")

    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(mujoco.egl, "GLContext", refuse)
    png = tmp_path / "p.png"
    assert cli.main(["replay", str(run), "--png", str(png)]) == 2
    _, err = capsys.readouterr()
    assert "libegl1" in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


# Bad input


def refused(capsys, *words):
    assert cli.main(["replay", *map(str, words)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


def test_no_display_is_said_with_what_else_works(run, capsys, no_display):
    assert "--web" in refused(capsys, run)


def test_a_folder_that_is_no_run_is_refused(tmp_path, capsys, run):
    assert "no summary.json" in refused(capsys, tmp_path, "--web")
    assert "is no folder" in refused(capsys, tmp_path / "missing", "--web")
    assert "give the folder" in refused(capsys, "--web")
    assert "twice" in refused(capsys, run, run, "--web")


def test_a_run_of_another_format_is_refused_by_number(run, tmp_path, capsys):
    old = shutil.copytree(run, tmp_path / "old")
    summary = json.loads((old / "summary.json").read_text())
    del summary["format"]
    (old / "summary.json").write_text(json.dumps(summary))
    assert "format 0, this one reads 1" in refused(capsys, old, "--web")
    (old / "summary.json").write_text("[]")
    assert "no summary" in refused(capsys, old, "--web")
    (old / "summary.json").write_text("{")
    assert "cannot be read" in refused(capsys, old, "--web")


def test_signals_of_another_format_are_refused_by_number(run, tmp_path, capsys):
    old = shutil.copytree(run, tmp_path / "old")
    table = pq.read_table(old / "signals.parquet")
    metadata = {**table.schema.metadata, b"armside.format": b"99"}
    pq.write_table(table.replace_schema_metadata(metadata), old / "signals.parquet")
    assert "format 99; this armside reads 1" in refused(capsys, old, "--save", tmp_path / "r.rrd")


def test_a_port_in_use_is_one_line(run, capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert f"port {port} is in use" in refused(capsys, run, "--web", "--port", port)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--magnification 0 --web", "magnification must be > 0"),
        ("--port 70000 --web", "port"),
        ("--save replay.txt", ".rrd"),
        ("--save missing/replay.rrd", "missing is no folder"),
        ("--png p.jpg", ".png"),
        ("--video film.avi", ".gif"),
    ],
)
def test_bad_options_are_refused(words, said, run, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in refused(capsys, run, *words.split())
    assert not list(tmp_path.iterdir())


def test_an_experiment_without_motion_has_no_replay(tmp_path, capsys):
    out = tmp_path / "rest"
    words = ["imu", "--motion", "rest", "--off", "3", "--on", "3", "--quiet", "--out", str(out)]
    assert cli.main(words) == 0
    assert "no replay" in refused(capsys, out, "--save", tmp_path / "r.rrd")


def test_the_replay_of_six_runs_is_small(tmp_path):
    from armside.scripts.viewers.stored_scene import stored_scene
    from armside.sim.records.stored_run import read_run
    from armside.sim.replay.scene import write_scenes

    assert cli.main(["laser", "--quiet", "--out", str(tmp_path / "six")]) == 0
    scene = stored_scene(read_run(tmp_path / "six"))
    file = tmp_path / "six.rrd"
    write_scenes(file, [scene])
    assert file.stat().st_size < 10e6
