"""Clients of others in cycles of 4 ms by the clock: answers late and lost, beside a bare timer.

    python tests/extras/clients_in_real_time.py [ROUNDS]

For an idle machine, and no part of the tests: how busy the machine is decides. The bare timer runs
in the same seconds, with the same priority and nothing to do: what the machine alone delays.
"""

import importlib.util
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import test_controller_clients as clients

from armside.sim.cell import LARGE_CELL
from armside.sim.controller import Hold, VirtualController
from armside.sim.controller.server import Server
from armside.sim.robot.kinematics_check import cell_model

PRIORITY = """
import os
from contextlib import suppress
with suppress(AttributeError, OSError):  # as whoever drives a robot gives its client
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
"""
TIMER = """
import gc, select, time
gc.disable()
tick, late = time.monotonic(), []
for k in range(1200):
    tick += 0.004
    while (left := tick - time.monotonic()) > 0.0:
        select.select([], [], [], left)
    late.append(1e3 * (time.monotonic() - tick))
print(max(late), sum(each > 1.0 for each in late))
"""


def measured(package: str, client: str, wire: Any, port: int) -> None:
    """One client for 1,200 samples; prints a line."""
    if importlib.util.find_spec(package) is None:
        print(f"{package}: not installed")
        return
    program = Hold(start=clients.START, seconds=20.0)
    model, rng = cell_model(LARGE_CELL, None), np.random.default_rng(1)
    controller = VirtualController.standing(model, LARGE_CELL, program, rng)
    ended, stop = list[int](), threading.Event()
    controller.on_end = lambda run, missed: ended.append(missed)
    server = Server(controller, wire, ("127.0.0.1", port), real_time=True)
    thread = threading.Thread(target=server.serve, args=(stop.is_set,))
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("client.py", clients.WAVE + client), ("timer.py", TIMER)):
            (Path(folder) / name).write_text(PRIORITY + text)
        about: dict[str, Any] = {"cwd": folder, "stdout": subprocess.PIPE, "text": True}
        timer = subprocess.Popen([sys.executable, "timer.py"], **about)
        thread.start()
        subprocess.run([sys.executable, "client.py"], check=True, timeout=60, **about)
        end = time.monotonic() + 30.0
        while not ended and time.monotonic() < end:
            time.sleep(0.05)
        stop.set()
        thread.join()
        worst, above = timer.communicate()[0].split()
    silent = ended[0] - controller.silence  # those after its end
    print(
        f"{package}: {server.late} late, {max(0, silent - server.late)} lost, {silent} cycles "
        f"without an answer; cycles began at most {1e3 * server.longest:.2f} ms late; bare timer "
        f"{float(worst):.2f} ms, {above} above 1 ms; priority {server.prioritised}"
    )


def main() -> None:
    """Each client, as often as asked."""
    for _ in range(int(sys.argv[1]) if len(sys.argv) > 1 else 1):
        measured("abb_robot_client", clients.ABB_ROBOT_CLIENT, clients.EgmWire(), 16510)
        measured("ABBRobotEGM", clients.ABB_ROBOT_EGM, clients.EgmWire(), 16511)
        measured("RSIPI", clients.RSIPI, clients.RsiWire(), 16512)


if __name__ == "__main__":
    main()
