"""The virtual robot behind a protocol, by command line."""

import json
import socket
import subprocess
import sys

import pytest

from armside import assets
from armside.scripts.cli import main

SERVE = [sys.executable, "-m", "armside.scripts.cli", "serve"]


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.1", 0))
        return udp.getsockname()[1]


def test_a_served_robot_is_learned_on_from_another_process(tmp_path):
    port, file = free_port(), assets.IRB1400_XML.parent / "two_link.toml"
    words = ["--protocol", "rsi", "--robot", str(file), "--program", "cut:pose=p1,radius=2"]
    served = subprocess.Popen(
        [*SERVE, *words, "--port", str(port), "--runs", "3", "--out", str(tmp_path / "served")],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert served.stdout is not None
    try:
        # Comes at once; it may take long to begin where others work.
        printed = served.stdout.readline()
        plant = f"rsi:port={port},wait=60"
        out = ["--out", str(tmp_path / "learned")]
        assert main(["learn", "--plant", plant, "--iterations", "1", "--quiet", *out]) == 0
        served.communicate(timeout=60)
    finally:
        served.kill()
    assert served.returncode == 0
    assert f"Speaking RSI to 127.0.0.1:{port}" in printed
    runs = json.loads((tmp_path / "served/summary.json").read_text())["runs"]
    assert [run["missed"] for run in runs] == [0, 0, 0]
    assert runs[0]["motor_rms"] == pytest.approx(runs[1]["motor_rms"], rel=0.05)  # other noise
    assert runs[2]["motor_rms"] < 0.8 * runs[1]["motor_rms"]
    (law,) = json.loads((tmp_path / "learned/summary.json").read_text())["laws"]
    assert law["error_two"][1] < 0.8 * law["error_two"][0]


def test_without_a_client_it_ends_in_one_line(capsys, tmp_path):
    out = ["--out", str(tmp_path / "served")]
    assert main(["serve", "--idle", "0.1", "--port", str(free_port()), *out]) == 1
    assert capsys.readouterr().err.strip().endswith("no client completed a run within 0.1 s")
    assert not (tmp_path / "served").exists()
