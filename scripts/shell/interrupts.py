"""Ctrl-C while other threads work: handled where the work can be stopped, and once.

Python raises KeyboardInterrupt wherever the main thread happens to be, and a second one while it
still waits for the threads of the first: a rollout in flight then outlives the interpreter.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Stop:
    """State of Ctrl-C: pressed or not."""

    asked = False

    def check(self) -> None:
        """Raise KeyboardInterrupt if it was."""
        if self.asked:
            raise KeyboardInterrupt


@contextmanager
def noticing(kept: Callable[[], str]) -> Iterator[Stop]:
    """End the block on Ctrl-C where it calls `Stop.check`, or at its end; the first one counts.
    Another error that the block raises after Ctrl-C is taken for its consequence.

    kept: the message at the end, which may be empty.

    Raises KeyboardInterrupt with this message after Ctrl-C.
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
