"""The same learning in process and over EGM and RSI; losses, silence, fuzz."""

import gc
import os
import select
import socket
import threading

import numpy as np
import pytest

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic
from armside.ilc.learning import learn
from armside.sim.controller import (
    Answer,
    Egm,
    GuidanceLimits,
    InProcess,
    Phase,
    Rsi,
    StreamedPlant,
)
from armside.sim.controller.egm import EgmWire
from armside.sim.controller.plant import LostError, program_of
from armside.sim.controller.rsi import RsiWire
from armside.sim.controller.server import Server

from .robots import CELL, MODEL, START, guided, path, programmed, served

PATIENCE = 20.0
"""[s], of both sides: a machine that is busy must lose nothing."""
FUZZED = 500 if os.environ.get("ARMSIDE_CI") else 150
PROTOCOLS = {"egm": (Egm, EgmWire, guided), "rsi": (Rsi, RsiWire, programmed)}


class Lossy:
    """A network that passes datagrams on; a share is lost, another doubled, another late by one."""

    def __init__(self, client, share, seed=1):
        self.lost = self.doubled = self.late = 0
        self._share, self._rng = share, np.random.default_rng(seed)
        self._client, self._controller = client, None
        self._front = self._socket()
        self._back = self._socket()
        self._held = {self._front: None, self._back: None}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._pass_on)

    @property
    def address(self):
        """Where the controller sends to."""
        return self._front.getsockname()

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        self._front.close()
        self._back.close()

    @staticmethod
    def _socket():
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        udp.bind(("127.0.0.1", 0))
        return udp

    def _pass_on(self):
        while not self._stop.is_set():
            for udp in select.select([self._front, self._back], [], [], 0.01)[0]:
                datagram, sender = udp.recvfrom(65535)
                if udp is self._front:
                    self._controller = sender
                    self._send(datagram, udp, self._back, self._client)
                else:
                    self._send(datagram, udp, self._front, self._controller)

    def _send(self, datagram, source, udp, to):
        draw, share = self._rng.random(), self._share
        if draw < share:
            self.lost += 1
            return
        if draw < 2 * share:
            self.late += 1
            self._held[source] = datagram
            return
        udp.sendto(datagram, to)
        if draw < 3 * share:
            self.doubled += 1
            udp.sendto(datagram, to)
        if self._held[source] is not None:
            udp.sendto(self._held[source], to)
            self._held[source] = None


def learned(link, updates=3):
    steps = ("speed", "acceleration")  # the path moves at once, and so does its correction
    plant = StreamedPlant(link, path(), GuidanceLimits.of(MODEL, CELL), beyond=steps)
    law = Heuristic(Q=ZeroPhaseButterworth(15.0, 0.004), gamma=0.7, delta=6)
    trials = list(learn(plant, law, plant.path, updates))
    return [trial.result for trial in trials], plant


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_learning_over_a_protocol_is_learning_in_process_bit_for_bit(protocol):
    link, wire, controller = PROTOCOLS[protocol]
    here, _ = learned(InProcess(controller(), additive=wire.additive))
    with link(port=0, patience=PATIENCE) as client:
        server = Server(controller(), wire(), client.address, patience=PATIENCE)
        with served(server):
            there, plant = learned(client)
    assert plant.lost == plant.refused == 0
    for a, b in zip(here, there, strict=True):
        np.testing.assert_array_equal(a, b)
    error = [np.abs(path() - y).max() for y in there]
    assert error[-1] < 0.6 * error[0]


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_learning_converges_when_a_hundredth_of_the_packets_is_lost_doubled_or_late(protocol):
    link, wire, controller = PROTOCOLS[protocol]
    whole, _ = learned(InProcess(controller(), additive=wire.additive), updates=4)
    with link(port=0, patience=PATIENCE) as client, Lossy(client.address, share=0.01) as lossy:
        server = Server(controller(), wire(), lossy.address, patience=0.2)
        with served(server):
            found, plant = learned(client, updates=4)
    assert min(lossy.lost, lossy.doubled, lossy.late) > 0
    assert plant.lost > 0 or plant.refused > 0
    error = [np.sqrt(np.mean((path() - y) ** 2)) for y in found]
    without = np.sqrt(np.mean((path() - whole[-1]) ** 2))
    assert error[-1] < 0.5 * error[0]
    assert error[-1] < 2.0 * without


def test_a_client_that_dies_leaves_the_robot_at_rest_and_the_server_ready():
    controller = guided()
    controller.silence = 3
    with Egm(port=0, patience=PATIENCE) as client:
        server = Server(controller, EgmWire(), client.address, patience=0.05)
        with served(server):
            first = StreamedPlant(client, path())
            state = first._waiting()
            for target in np.rad2deg(path()[:20]):
                client.answer(Answer(values=target, additive=False), state)
                state = client.receive()
            second, _ = learned(client, updates=1)  # after the silence of the first
    assert controller.runs >= 2
    assert np.isfinite(second[-1]).all()


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_fuzzed_datagrams_neither_crash_nor_move_the_robot_beyond_its_limits(protocol):
    _, wire, controller = PROTOCOLS[protocol]
    robot = controller(seconds=0.3) if protocol == "egm" else controller()
    rng, runs = np.random.default_rng(5), []
    robot.on_end = lambda run, missed: runs.append(run)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.1", 0))
        udp.settimeout(PATIENCE)
        server = Server(robot, wire(), udp.getsockname(), patience=0.001)
        with served(server):
            for k in range(FUZZED):
                heard, back = udp.recvfrom(65535)
                udp.sendto(fuzzed(wire(), wire().decode_state(heard), rng, k), back)
    assert server.wrong_count > FUZZED / 5
    assert all(0 < len(reason) < 200 and "\n" not in reason for reason in server.wrong)
    for run in runs:
        assert not [hit for hit in run.limits_hit if hit[0] in ("joint", "speed")]


def fuzzed(wire, state, rng, k):
    """A datagram: noise, a message cut or changed, or numbers out of all bounds."""
    size = int(rng.choice([0, 1, 10, 300, 5000]))
    values = rng.choice([0.0, 1e-300, 3.0, -7.0, 400.0, 1e30, -1e308, np.inf, np.nan], size=2)
    if k % 4 == 0:
        return rng.bytes(size)
    answer = Answer(values=np.tile(values, rng.choice([0, 1, 1, 4])), additive=wire.additive)
    datagram = bytearray(wire.encode_answer(answer, state.time))
    if k % 4 == 1 and datagram:
        del datagram[int(rng.integers(len(datagram))) :]
    if k % 4 == 2 and datagram:
        for place in rng.integers(len(datagram), size=3):
            datagram[place] = int(rng.integers(256))
    return bytes(datagram)


def test_the_program_of_a_controller_can_be_listened_to():
    controller = programmed()
    np.testing.assert_allclose(program_of(InProcess(controller, additive=True)), path(), atol=1e-15)
    assert controller.phase is Phase.WAITING


def test_a_robot_that_stands_elsewhere_is_moved_to_the_start_first():
    away = path() + np.array([0.1, -0.05])
    plant = StreamedPlant(InProcess(guided()), away, GuidanceLimits.of(MODEL, CELL))
    measured = plant.run(np.zeros_like(away))
    assert np.abs(measured[0] - away[0]).max() < 0.05 * np.abs(away[0] - START).max()


def test_a_correction_beyond_the_limits_is_refused_before_anything_is_sent():
    controller = guided()
    plant = StreamedPlant(InProcess(controller), path(), GuidanceLimits.of(MODEL, CELL))
    wild = np.zeros_like(path())
    wild[30, 1] = 0.5
    with pytest.raises(ValueError, match=r"sample 30: axis 2 .* deg/s .*; nothing was sent"):
        plant.run(wild)
    assert controller.phase is Phase.WAITING
    with pytest.raises(ValueError, match=r"correction must have shape \(60, 2\)"):
        plant.run(wild[:-1])


def test_a_first_answer_that_is_always_refused_is_an_error_and_no_endless_loop():
    controller = programmed()
    beyond = ("size", "speed", "acceleration")
    plant = StreamedPlant(InProcess(controller, additive=True), path(), beyond=beyond)
    wild = np.full_like(path(), 1.0)  # 57 degrees at once
    with pytest.raises(LostError, match="asked for sample 0 250 times: it refuses the answer"):
        plant.run(wild)
    assert controller.phase is Phase.WAITING


def test_in_real_time_garbage_is_collected_between_runs_only():
    seen = list[bool]()

    def over():
        seen.append(gc.isenabled())
        return len(seen) > 5

    server = Server(programmed(), RsiWire(), ("127.0.0.1", 9), real_time=True)
    server.serve(over)
    assert gc.isenabled()
    assert not any(seen)


def test_without_a_controller_the_client_says_where_it_listened():
    with Rsi(port=0, patience=0.05) as client, pytest.raises(TimeoutError, match="no message of a"):
        StreamedPlant(client, path()).run(np.zeros_like(path()))


def test_a_port_that_is_taken_is_named():
    with Rsi(port=0) as client:
        port = client.address[1]
        with pytest.raises(OSError, match=rf"cannot listen at 127\.0\.0\.1:{port}"):
            Rsi(port=port)
