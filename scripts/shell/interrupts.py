"""Ctrl-C while other threads work: noticed where the work can be put down, and once.

Python raises KeyboardInterrupt wherever the main thread happens to be, and a second one while it
still waits for the threads of the first: a rollout in flight then outlives the interpreter.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Stop:
    """Whether Ctrl-C was pressed."""

    asked = False

    def check(self) -> None:
        """Raise KeyboardInterrupt if it was."""
        if self.asked:
            raise KeyboardInterrupt


@contextmanager
def noticing(kept: Callable[[], str]) -> Iterator[Stop]:
    """Ctrl-C ends the block where it calls `Stop.check`, or at its end; pressed again, it does
    nothing. Whatever else the block raises after it is taken for its consequence.

    kept: what to say at the end; empty for nothing.

    Raises KeyboardInterrupt, with what there is to say, after Ctrl-C.
    """
    stop = Stop()
    before = signal.getsignal(signal.SIGINT)
    # Only the main thread may handle signals, and a process in the background may ignore this one.
    ours = threading.current_thread() is threading.main_thread() and callable(before)

    def note(*_: object) -> None:
        stop.asked = True

    if ours:
        signal.signal(signal.SIGINT, note)
    try:
        yield stop
        stop.check()
    except (Exception, KeyboardInterrupt) as error:
        if stop.asked or isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt(kept()) from None
        raise
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)
