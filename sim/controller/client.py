"""The client's side of EGM and RSI: messages of a controller in, answers out."""

import select
import socket
import time
from contextlib import suppress
from typing import Protocol

from .messages import Answer, State, Wire, WireError
from .server import LARGEST, Address


class Connection(Protocol):
    """A connection with a controller."""

    additive: bool
    """Answers are corrections that the controller adds to its program, not absolute angles."""

    def receive(self) -> State:
        """The newest message. Raises TimeoutError when none comes."""
        ...

    def answer(self, answer: Answer, to: State) -> None:
        """Answer a message."""

    def begin(self) -> None:
        """A run begins: messages that wait are not those of this run."""


class Udp:
    """A link over UDP. The controller speaks first, to the address that this binds."""

    def __init__(self, wire: Wire, address: Address, patience: float) -> None:
        self.additive, self._wire, self._patience = wire.additive, wire, patience
        self.wrong = 0
        """Datagrams that were no messages."""
        self._controller: Address | None = None
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._udp.bind(address)
        except OSError as error:
            self._udp.close()
            raise OSError(f"cannot listen at {address[0]}:{address[1]}: {error}") from error
        self._udp.setblocking(False)

    @property
    def address(self) -> Address:
        """Where the controller sends to."""
        return self._udp.getsockname()

    def __enter__(self) -> "Udp":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the port back."""
        self._udp.close()

    def begin(self) -> None:
        self._wire.forget()
        while self._next() is not None:
            pass

    def receive(self) -> State:
        end = time.monotonic() + self._patience
        while (left := end - time.monotonic()) > 0.0:
            if select.select([self._udp], [], [], left)[0] and (state := self._next()) is not None:
                return state
        host, port = self.address
        raise TimeoutError(f"no message of a controller at {host}:{port} in {self._patience:g} s")

    def answer(self, answer: Answer, to: State) -> None:
        if self._controller is not None:
            with suppress(BlockingIOError, ConnectionError):  # a lost message, as any other
                self._udp.sendto(self._wire.encode_answer(answer, to.time), self._controller)

    def _next(self) -> State | None:
        while True:
            try:
                datagram, sender = self._udp.recvfrom(LARGEST)
                state = self._wire.decode_state(datagram)
            except BlockingIOError:
                return None
            except (WireError, ConnectionError):
                self.wrong += 1
                continue
            self._controller = sender
            return state


class Egm(Udp):
    """ABB's Externally Guided Motion, joint guidance: absolute angles. Port 6510 is ABB's default.

    Raises OSError when the port is taken, ImportError without the package protobuf.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 6510, *, patience: float = 2.0) -> None:
        """`patience`: how long to wait for a message [s]."""
        from .egm import EgmWire

        super().__init__(EgmWire(), (host, port), patience)


class Rsi(Udp):
    """KUKA's Robot Sensor Interface, axis corrections. Raises OSError when the port is taken."""

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 59152,
        *,
        relative: bool = False,
        patience: float = 2.0,
    ) -> None:
        """`relative`: the controller adds corrections up; `patience`: for a message [s]."""
        from .rsi import RsiWire

        super().__init__(RsiWire(relative), (host, port), patience)
