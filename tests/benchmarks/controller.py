"""The served robot's own part of a controller's cycle of 4 ms: message, answer and physics."""

import time
from collections.abc import Sequence
from contextlib import suppress
from statistics import median, quantiles
from typing import Any

import numpy as np

from armside.sim.controller import Answer, Hold, VirtualController
from armside.sim.controller.egm import EgmWire
from armside.sim.controller.rsi import RsiWire
from armside.sim.laser import Cut, prepare

from ._timing import Row

CYCLES = 1200
"""Cycles measured, the first among them."""


def measured() -> Sequence[Row]:
    """Processor time of this thread over the cycles of one run; EGM where protobuf is there."""
    made = prepare(Cut())
    rng, start = np.random.default_rng(0), made.loaded.reference[0]
    model, cell = made.loaded.model, made.cut.cell
    served: list[tuple[str, VirtualController, Any]] = []
    with suppress(ImportError):
        robot = VirtualController.standing(model, cell, Hold(start=start), rng)
        served.append(("EGM", robot, EgmWire()))
    served.append(("RSI", VirtualController(made.loaded, cell, rng), RsiWire()))
    rows: list[Row] = []
    for name, robot, wire in served:
        cycles = _cycles(robot, wire)
        rows.append(Row(f"{name}: own part of a cycle, median", median(cycles)))
        rows.append(Row(f"{name}: 99 of 100 cycles within", quantiles(cycles, n=100)[-1]))
        rows.append(Row(f"{name}: first cycle of a run", cycles[0]))
    return rows


def _cycles(robot: VirtualController, wire: Any) -> list[float]:
    """[s] of each cycle, the client's answer apart."""
    found = list[float]()
    for _ in range(CYCLES):
        began = time.thread_time()
        state = robot.state()
        wire.encode_state(state)
        own = time.thread_time() - began
        values = np.zeros_like(state.planned) if wire.additive else state.planned
        datagram = wire.encode_answer(Answer(values=values, additive=wire.additive), state.time)
        began = time.thread_time()
        robot.cycle(wire.decode_answer(datagram, state))
        found.append(own + time.thread_time() - began)
    return found
