"""A small robot behind a controller, for the tests of protocols."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from armside import assets
from armside.sim.controller import Hold, VirtualController
from armside.sim.controller.server import Server
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot.virtual_robot import VirtualRobot
from armside.sim.robot_file.find import read_cell

CELL = read_cell(assets.IRB1400_XML.parent / "two_link.toml")
MODEL = cell_model(CELL, None)
START = np.array([-0.5, 1.5])


def path(samples: int = 60, size: float = 0.05) -> np.ndarray:
    """There and back, at rest at both ends, (N, 2) [rad]."""
    share = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(samples) / (samples - 1))
    return START + size * share[:, None] * np.array([1.0, -0.6])


@contextmanager
def served(server: Server) -> Iterator[Server]:
    """The server in a thread of its own."""
    stop = threading.Event()
    thread = threading.Thread(target=server.serve, args=(stop.is_set,))
    thread.start()
    try:
        yield server
    finally:
        stop.set()
        thread.join()


def guided(seed: int = 3, seconds: float = 2.0) -> VirtualController:
    """A robot that stands still until it is guided."""
    program = Hold(start=START, seconds=seconds)
    return VirtualController.standing(MODEL, CELL, program, np.random.default_rng(seed))


def programmed(samples: int = 60, seed: int = 3) -> VirtualController:
    """A robot that runs a program, with corrections."""
    loaded = VirtualRobot(MODEL).load(path(samples))
    return VirtualController(loaded, CELL, np.random.default_rng(seed))
