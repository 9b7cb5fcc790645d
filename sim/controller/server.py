"""The UDP side of a virtual controller: it sends a message each cycle and takes the answers.

As real controllers do, it speaks first: it sends to the address of the client, and takes answers
from there alone.
"""

import gc
import os
import select
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field

from .controller import VirtualController
from .messages import Answer, Phase, State, Wire, WireError

PRIORITY = 10
"""Of Linux's real-time scheduling, 1 to 99: above every ordinary program. ESTIMATE: low among those
that are real-time themselves."""


@contextmanager
def real_time() -> Iterator[bool]:
    """This thread before all ordinary ones: yields whether the system allows it.

    Python's garbage collector is off, as it takes up to a cycle: call `gc.collect` between runs.
    Both are as before at the end.
    """
    collecting, before = gc.isenabled(), None
    gc.collect()
    gc.disable()
    with suppress(AttributeError, OSError):  # not on this system, or not allowed
        ordinary = os.sched_getscheduler(0), os.sched_getparam(0)
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
        before = ordinary
    try:
        yield before is not None
    finally:
        if before is not None:
            os.sched_setscheduler(0, *before)
        if collecting:
            gc.enable()


Address = tuple[str, int]
LARGEST = 65_535
AWAITED = 0.02
"""[s], between messages while no client answers."""
CYCLE_MS = 4
MOST_REASONS = 100
"""Reasons for refusals that are kept."""


@dataclass
class Server:
    """Carries the messages of one virtual controller to one client."""

    controller: VirtualController
    wire: Wire
    client: Address
    real_time: bool = False
    """Cycles of 4 ms by the clock; otherwise the next begins as soon as the client answers."""
    patience: float = 0.5
    """[s], for an answer, where cycles do not follow the clock."""
    late: int = 0
    """Answers that came after their cycle or twice. In real time an absolute target that is one
    cycle late still serves the next, where that has none: the newest counts."""
    wrong: list[str] = field(default_factory=list[str])
    """What was wrong with datagrams that are no messages; the first of each reason."""
    wrong_count: int = 0
    clients: list[Address] = field(default_factory=list[Address], init=False)
    """Addresses that answered, each change of them; the first hundred."""
    longest: float = 0.0
    """[s], the longest that a cycle began after its time, in real time."""
    prioritised: bool | None = field(default=None, init=False)
    """The system gave the thread the priority of real time; None where it was not asked."""
    _before: State | None = field(default=None, init=False, repr=False)
    """Message of the last cycle."""

    def __post_init__(self) -> None:
        self._sender = self.client  # of the last datagram

    def serve(self, until: Callable[[], bool]) -> None:
        """Send and receive until `until()` holds, asked each cycle. Raises OSError."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
            udp.bind(("127.0.0.1", 0))
            udp.setblocking(False)
            with real_time() if self.real_time else nullcontext() as self.prioritised:
                tick = time.monotonic()
                while not until():
                    tick = self._cycle(udp, tick)

    def _cycle(self, udp: socket.socket, tick: float) -> float:
        controller = self.controller
        waiting = controller.phase is Phase.WAITING
        state = controller.state()
        overdue = self._overdue(udp)
        with suppress(BlockingIOError, ConnectionError):  # a lost message, as any other
            udp.sendto(self.wire.encode_state(state), self.client)
        controller.ahead()
        if self.real_time:
            tick += 1e-3 * CYCLE_MS
            answer = None
            for one in self._answers(udp, state, tick):
                self.late += None not in (one, answer)  # the one before was due earlier
                answer = one or answer
            answer = answer or overdue
            late = time.monotonic() - tick
            self.longest = max(self.longest, 0.0 if waiting else late)
            tick = time.monotonic() if late > 0.25 else tick
        else:
            waits = {Phase.WAITING: AWAITED, Phase.GUIDED: self.patience, Phase.STOPPING: 0.0}
            answers = self._answers(udp, state, time.monotonic() + waits[controller.phase])
            answer = next((one for one in answers if one is not None), None)
        controller.cycle(answer)
        self._before = state
        if controller.phase is Phase.WAITING:
            self.wire.forget()
            if self.real_time and not waiting:
                gc.collect()
        return tick

    def _overdue(self, udp: socket.socket) -> Answer | None:
        """Counts answers that came after their cycle; the newest serves the next one, if it is
        absolute. Corrections belong to their place on the path, and are not used later."""
        datagrams = self._received(udp)
        if not self.real_time or self._before is None:
            self.late += len(datagrams)
            return None
        found = (self._answer(datagram, self._before) for datagram in datagrams)
        overdue = [answer for answer in found if answer is not None]
        self.late += len(overdue)
        return overdue[-1] if overdue and not self.wire.additive else None

    def _answers(self, udp: socket.socket, state: State, end: float) -> Iterator[Answer | None]:
        """What datagrams answer a message until a time [s]; None for those that do not."""
        while (left := end - time.monotonic()) > 0.0 and select.select([udp], [], [], left)[0]:
            for datagram in self._received(udp, most=1):
                yield self._answer(datagram, state)

    def _answer(self, datagram: bytes, state: State) -> Answer | None:
        try:
            answer = self.wire.decode_answer(datagram, state)
        except WireError as error:
            self.wrong_count += 1
            if (reason := str(error)) not in self.wrong and len(self.wrong) < MOST_REASONS:
                self.wrong.append(reason)
            return None
        self.late += answer is None
        if self._sender not in self.clients[-1:] and len(self.clients) < MOST_REASONS:
            self.clients.append(self._sender)
        return answer

    def _received(self, udp: socket.socket, most: int = 10_000) -> list[bytes]:
        """Datagrams of the client that are there; others are dropped."""
        found = list[bytes]()
        while len(found) < most:
            try:
                datagram, sender = udp.recvfrom(LARGEST)
            except BlockingIOError:
                break
            except ConnectionError:  # nobody listens at the client's port
                continue
            if sender[0] == self.client[0]:
                self._sender = sender
                found.append(datagram)
        return found


def resolved(host: str, port: int) -> Address:
    """IPv4 address of a host. Raises ValueError for one that is not known."""
    try:
        found = socket.getaddrinfo(host, port, socket.AF_INET, socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise ValueError(f"unknown host {host!r}") from error
    address = found[0][4]
    return str(address[0]), int(address[1])
