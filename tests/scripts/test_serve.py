"""The virtual robot behind a protocol, by command line."""

import json
import socket
import subprocess
import sys
import threading
import xml.etree.ElementTree as ET
from types import SimpleNamespace

import numpy as np
import pytest

from armside import assets
from armside.scripts.cli import main
from armside.scripts.commands.serve import _row, _told

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


WORDS = ["--protocol", "rsi", "--program", "cut:pose=p1,radius=2", "--idle", "20"]


def client(port, texts):
    """Answer the controller once it waits: texts by the IPOC of its messages."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.1", port))
        udp.settimeout(60)
        heard, back = udp.recvfrom(65535)
        while ET.fromstring(heard).find("Digout").get("o1") != "0":
            heard, back = udp.recvfrom(65535)
        for text in texts:
            udp.sendto(text.format(ipoc=ET.fromstring(heard).findtext("IPOC")).encode(), back)
            heard, back = udp.recvfrom(65535)


@pytest.mark.parametrize("option", ["", "--quiet", "--json"])
def test_clients_runs_garbage_and_refusals_are_lines_as_they_come(option, tmp_path, capsys):
    def sen(axis):
        return f'<Sen><AKorr A1="{axis}" A2="0"/><IPOC>{{ipoc}}</IPOC></Sen>'

    file, port = assets.IRB1400_XML.parent / "two_link.toml", free_port()
    end = "<Sen><EStr>Error: over</EStr><IPOC>{ipoc}</IPOC></Sen>"
    thread = threading.Thread(
        target=client, args=(port, [sen(0), "nonsense", sen(0), sen(9.0), sen(0), end])
    )
    thread.start()
    robot = ["--robot", str(file), "--port", str(port), "--runs", "1", *option.split()]
    assert main(["serve", *WORDS, *robot, "--out", str(tmp_path / "served")]) == 0
    thread.join()
    out, err = capsys.readouterr()
    assert err == ""
    if option:
        assert out == "" if option == "--quiet" else json.loads(out)["status"] == "done"
        return
    lines = [line for line in out.splitlines() if line[:4] in ("Clie", "Not ", "Refu", "Run ")]
    assert [line.partition(" of ")[0].partition(":")[0] for line in lines] == [
        "Client at 127.0.0.1",
        "Not a message",
        "Refused",
        "Run",
    ]
    assert "axis 1 must be at most" in lines[2]
    (run,) = json.loads((tmp_path / "served/summary.json").read_text())["runs"]
    assert f"{run['missed']} answers lost, late or refused" in lines[3]
    assert f"motor error RMS {1e3 * run['motor_rms']:.4g} mrad" in lines[3]
    assert not run["abandoned"]
    assert "silent" not in lines[3]
    assert "; the client fell silent" in _told(run | {"abandoned": True})


def test_a_run_is_counted_in_seconds_and_radians_of_the_arm_side():
    """A motor that stays 2 mrad behind; a guided one behind what it is told, a program's not."""
    still = np.zeros((251, 2))
    run = SimpleNamespace(
        time=0.004 * np.arange(251), reference=still + 0.5, correction=still + 1e-3,
        motor_angle=still + 0.5 + 1e-3 - 2e-3,
    )  # fmt: skip
    guided, programmed = (_row(run, 3, of) for of in (True, False))
    assert guided == {"seconds": pytest.approx(1.0), "missed": 3, "motor_rms": pytest.approx(2e-3)}
    assert programmed["motor_rms"] == pytest.approx(1e-3)
