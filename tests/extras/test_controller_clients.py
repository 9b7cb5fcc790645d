"""Clients of EGM and RSI that nobody here wrote drive the virtual robot."""

import contextlib
import importlib.util
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from armside.sim.cell import LARGE_CELL
from armside.sim.controller import Hold, VirtualController
from armside.sim.controller.egm import EgmWire
from armside.sim.controller.rsi import RsiWire
from armside.sim.controller.server import Server
from armside.sim.robot.kinematics_check import cell_model

SAMPLES = 1200
START = np.array([0.0, 0.2, 0.1, 0.0, 0.5, 0.0])


@contextlib.contextmanager
def robot(wire, port):
    """The large robot behind a protocol, until the block ends."""
    model = cell_model(LARGE_CELL, None)
    program = Hold(start=START, seconds=20.0)
    controller = VirtualController.standing(model, LARGE_CELL, program, np.random.default_rng(1))
    ended = []
    controller.on_end = lambda run, missed: ended.append((run, missed))
    server = Server(controller, wire, ("127.0.0.1", port), patience=20.0)
    stop = threading.Event()
    thread = threading.Thread(target=server.serve, args=(stop.is_set,))
    thread.start()
    try:
        yield controller, server, ended
        _until(lambda: ended)  # the robot comes to rest
    finally:
        stop.set()
        thread.join()


def _until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)


WAVE = """
import numpy as np
SAMPLES, START = 1200, np.array([0.0, 0.2, 0.1, 0.0, 0.5, 0.0])
def wave(k):  # axis 1 moves by 0.3 degrees and back: no step of it exceeds a speed limit
    return np.rad2deg(START) + np.eye(6)[0] * 0.3 * np.sin(np.pi * k / SAMPLES) ** 2
"""
"""Clients run in processes of their own: two of them define the same messages differently."""
ABB_ROBOT_CLIENT = """
from abb_robot_client.egm import EGM
client = EGM(port=16510)
for k in range(SAMPLES):
    there, state = client.receive_from_robot(timeout=10.0)
    assert there and len(state.joint_angles) == 6
    assert client.send_to_robot(wave(k))
"""
ABB_ROBOT_EGM = """
from ABBRobotEGM import EGM
with EGM(port=16511) as client:
    for k in range(SAMPLES):
        there, state = client.receive_from_robot(timeout=10.0)
        assert there and state.motors_on
        client.send_to_robot(wave(k))
"""
RSIPI = """
import pathlib, time
import xml.etree.ElementTree as ET
import RSIPI
if __name__ == "__main__":
    config = pathlib.Path(RSIPI.__file__).parent / "contexts" / "RSI_EthernetConfig_Joints.xml"
    tree = ET.parse(config)
    for tag, text in (("IP_NUMBER", "127.0.0.1"), ("PORT", "16512")):
        tree.getroot().find(f"CONFIG/{tag}").text = text
    tree.write("config.xml")
    client = RSIPI.RSIAPI("config.xml", rsi_mode="absolute")
    client.start()
    assert client.wait_for_connection(timeout=20.0)
    first = int(client.monitoring.get_ipoc())
    # its own process answers
    while (k := (int(client.monitoring.get_ipoc()) - first) // 4) < SAMPLES:
        client.motion.update_joints(A1=float(wave(k)[0]))
        time.sleep(0.001)
    client.motion.update_joints(A1=float(wave(SAMPLES)[0]))
    client.stop()
"""


@pytest.mark.parametrize(
    ("package", "client", "wire", "port"),
    [
        ("abb_robot_client", ABB_ROBOT_CLIENT, EgmWire, 16510),
        ("ABBRobotEGM", ABB_ROBOT_EGM, EgmWire, 16511),
        ("RSIPI", RSIPI, RsiWire, 16512),
    ],
)
def test_a_client_of_others_drives_it_for_1200_samples(tmp_path, package, client, wire, port):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"needs the package {package}")
    (tmp_path / "client.py").write_text(WAVE + client)
    with robot(wire(), port) as (controller, server, ended):
        subprocess.run(
            [sys.executable, "client.py"], cwd=tmp_path, check=True, timeout=60, capture_output=True
        )
        server.patience = 0.01  # the client is gone
    run, missed = ended[0]
    assert missed == controller.silence  # those after its end
    assert len(run.time) >= SAMPLES
    assert not controller.refusals
    moved = np.abs(np.rad2deg(run.motor_angle[:, 0] - START[0])).max()
    assert moved == pytest.approx(0.3, rel=0.05)
