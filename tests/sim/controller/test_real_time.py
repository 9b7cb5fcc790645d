"""Cycles by the clock: priority of the thread, and answers that come after their cycle."""

import gc
import os
import threading

import numpy as np
import pytest

from armside.sim.controller import Answer
from armside.sim.controller.egm import EgmWire
from armside.sim.controller.rsi import RsiWire
from armside.sim.controller.server import PRIORITY, Server, real_time

from .robots import guided, programmed


class Datagrams:
    """A socket that holds datagrams, keeps what is sent, and says when it was read."""

    def __init__(self, *held):
        self.held, self.sent = list(held), []

    def recvfrom(self, size):
        if not self.held:
            raise BlockingIOError
        return self.held.pop(0), ("127.0.0.1", 9)

    def sendto(self, datagram, to):
        self.sent.append(datagram)


def served(wire, controller, **how):
    return Server(controller, wire, ("127.0.0.1", 9), **how)


@pytest.mark.parametrize(("wire", "serves"), [(EgmWire, True), (RsiWire, False)])
def test_an_overdue_answer_is_counted_and_serves_where_it_is_absolute(wire, serves):
    controller = guided() if wire is EgmWire else programmed()
    server, client = served(wire(), controller, real_time=True), wire()
    server._before = state = controller.state()
    values = state.planned if serves else np.zeros(2)
    datagrams = [
        client.encode_answer(Answer(values=values + step, additive=not serves), state.time)
        for step in (0.0, 0.01)
    ]
    found = server._overdue(Datagrams(*datagrams))  # pyright: ignore[reportArgumentType]
    assert server.late == 2
    assert (found is not None) == serves
    if found is not None:
        assert found.values is not None
        np.testing.assert_array_equal(found.values, values + 0.01)  # the newest


def test_without_the_clock_an_overdue_answer_is_only_counted():
    controller = guided()
    server, client = served(EgmWire(), controller), EgmWire()
    server._before = state = controller.state()
    datagram = client.encode_answer(Answer(values=state.planned, additive=False), state.time)
    assert server._overdue(Datagrams(datagram)) is None  # pyright: ignore[reportArgumentType]
    assert server.late == 1


@pytest.mark.skipif(not hasattr(os, "SCHED_FIFO"), reason="needs Linux's real-time scheduling")
def test_the_thread_has_priority_and_no_collection_until_the_end():
    seen = list[tuple[object, ...]]()

    def within():
        with real_time() as granted:
            seen.append((granted, os.sched_getscheduler(0), os.sched_getparam(0).sched_priority))
            seen.append((gc.isenabled(),))
        seen.append((os.sched_getscheduler(0),))

    before = os.sched_getscheduler(0)
    thread = threading.Thread(target=within)
    thread.start()
    thread.join()
    (granted, policy, priority), (collecting,), (after,) = seen
    assert (policy, priority) == ((os.SCHED_FIFO, PRIORITY) if granted else (before, 0))
    assert not collecting
    assert gc.isenabled()
    assert after == os.sched_getscheduler(0) == before
