"""Signals that end a command: Ctrl-C, and those of a supervisor or a terminal that closes.

Python raises KeyboardInterrupt wherever the main thread happens to be, and a second one while it
still waits for the threads of the first: a rollout in flight then outlives the interpreter.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

INTERRUPTED = 130
"""Exit status after Ctrl-C; after another signal, 128 and its number."""
LATER = 0.05
"""[s], until a signal comes again."""
ENDING = (signal.SIGTERM, signal.SIGHUP)
"""Signals beside Ctrl-C after which a command cleans up and ends."""


class Terminated(KeyboardInterrupt):
    """Ended by a signal other than Ctrl-C."""

    def __init__(self, number: int, message: str = "") -> None:
        super().__init__(message)
        self.number = number


def interruption(number: int, message: str = "") -> KeyboardInterrupt:
    """The exception for a signal."""
    if number == signal.SIGINT:
        return KeyboardInterrupt(message)
    return Terminated(number, message)


def exit_status(stop: KeyboardInterrupt) -> int:
    """Exit status after an interruption."""
    return 128 + stop.number if isinstance(stop, Terminated) else INTERRUPTED


class Signals:
    """Signals of this process: those that have come, in their order, and their handling."""

    def __init__(self) -> None:
        self.come: list[int] = []
        self._handled: list[int] = []

    def handle(self) -> None:
        """Let Ctrl-C and the ending signals raise their exception, unless they are ignored, as
        below nohup."""
        for number in (signal.SIGINT, *ENDING):
            if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                signal.signal(number, self._end)
                self._handled.append(number)
        sys.unraisablehook = self._unraisable

    def ignore(self) -> None:
        """Nothing is left to be interrupted."""
        for number in self._handled:
            signal.signal(number, signal.SIG_IGN)

    def consequence(self, error: Exception) -> Exception | KeyboardInterrupt:
        """The error, or the interruption that it follows from: compiled code, in which a signal is
        noticed, has errors of its own for it."""
        return interruption(self.come[0]) if self.come else error

    def _end(self, number: int, _: object) -> NoReturn:
        self.come.append(number)
        raise interruption(number)

    def _unraisable(self, lost: Any) -> None:
        """A signal that came where nothing can be raised, as in a function that compiled code
        calls, comes again a little later. Other errors of this kind are a library's."""
        if isinstance(lost.exc_value, KeyboardInterrupt) and self.come:
            again = threading.Timer(LATER, os.kill, (os.getpid(), self.come[0]))
            again.daemon = True
            again.start()


SIGNALS = Signals()
"""Of this process."""


class Stop:
    """The first signal that has come, if any."""

    number = 0

    def check(self) -> None:
        """Raise KeyboardInterrupt if one has."""
        if self.number:
            raise interruption(self.number)


@contextmanager
def noticing(kept: Callable[[], str]) -> Iterator[Stop]:
    """End the block on a signal where it calls `Stop.check`, or at its end, with KeyboardInterrupt
    and the message `kept`, which may be empty; the first one counts. Another error that the block
    raises after a signal is taken for its consequence."""
    stop, before = Stop(), dict[int, Any]()
    if threading.current_thread() is threading.main_thread():  # others may handle no signals
        handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, *ENDING)}
        # A process in the background may ignore one.
        before = {number: handler for number, handler in handlers.items() if callable(handler)}

    def note(number: int, _: object) -> None:
        stop.number = stop.number or number

    for number in before:
        signal.signal(number, note)
    try:
        yield stop
        stop.check()
    except (Exception, KeyboardInterrupt) as error:
        if stop.number or isinstance(error, KeyboardInterrupt):
            number = getattr(error, "number", signal.SIGINT)
            raise interruption(stop.number or number, kept()) from None
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
