"""A replay shown: web viewer, browser, pictures, and films."""

import http.client
import os
import re
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


@pytest.fixture(scope="module")
def run(replayed):
    return replayed / "two"


@pytest.fixture(scope="module")
def file(replayed):
    return replayed / "two.rrd"


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


def test_ctrl_c_ends_the_web_viewer_cleanly(run):
    command = [sys.executable, "-m", "armside.scripts.cli", "replay", str(run), "--web"]
    command += ["--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    line = process.stdout.readline()
    address = re.search(r"http://127\.0\.0\.1:(\d+)/", line)
    assert address, line
    process.send_signal(signal.SIGINT)
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
SMALL = {"width": 800, "height": 450}
"""Of the page: each of its pixels is drawn on the processor."""


def looks_full(png):
    return (
        colours(png, ROBOT)["orange"] > 500
        and colours(png, PATHS)["orange"] > 200
        and colours(png, PATHS)["blue"] > 200
        and colours(png, MOTOR_ERROR)["green"] > 100
        and colours(png, DEVIATION)["orange"] > 100
    )


def test_chromium_shows_robot_and_plots_and_asks_nobody_else(viewer, require_program):
    require_program("chromium", "google-chrome")
    driver = require_program("chromedriver")
    from tests.gallery._browser import page

    with page(f"{viewer.address}?renderer=webgl", driver=driver, **SMALL) as shown:
        png = shown.screenshot_when(looks_full, within=240)
        answered = {url for url in shown.answered() if not url.startswith(("data:", "blob:"))}
    assert looks_full(png), {box: colours(png, box) for box in (ROBOT, PATHS, MOTOR_ERROR)}
    assert all(url.startswith(viewer.address) for url in answered), answered
    assert any(url.endswith("/replay.rrd") for url in answered)


def test_a_picture_of_one_run_or_two_shows_robot_and_paths(run, tmp_path, graphics):
    """Two stand one above the other, at one magnification."""
    other, alone, both = (tmp_path / name for name in ("other", "alone.png", "both.png"))
    line = f"laser --iterations 0 --speed 30 --quiet --out {other}"
    assert cli.main(line.split()) == 0
    for words in ([run, "--png", alone], [run, other, "--png", both]):
        assert cli.main(["replay", *map(str, words), "--quiet"]) == 0
    with Image.open(alone) as one, Image.open(both) as two:
        assert two.size == (one.width, 2 * one.height)
    assert colours(alone.read_bytes(), (0.0, 0.0, 0.57, 1.0))["orange"] > 10_000
    assert colours(alone.read_bytes(), (0.58, 0.1, 1.0, 0.9))["blue"] > 500
    for top, bottom in ((0.1, 0.45), (0.55, 0.9)):
        assert colours(both.read_bytes(), (0.58, top, 1.0, bottom))["blue"] > 500


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


def test_without_opengl_it_says_what_is_missing(run, monkeypatch, bad_input):
    import mujoco.egl

    def refuse(*_):
        raise ImportError("no libEGL.so")

    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(mujoco.egl, "GLContext", refuse)
    bad_input(f"replay {run} --png p.png", "libegl1")
