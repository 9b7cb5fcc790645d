"""A thread that keeps cycles of a few milliseconds: its priority, and no garbage collection."""

import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager

PRIORITY = 10
"""Of Linux's real-time scheduling, 1 to 99: above every ordinary program. ESTIMATE: low among those
that are real-time themselves."""


@contextmanager
def real_time() -> Iterator[bool]:
    """This thread before all ordinary ones, where the system allows it: yields whether it does.

    Python's garbage collector is off, as it takes up to a cycle; call `gc.collect` between runs.
    Both are as before at the end.
    """
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    before = _prioritised()
    try:
        yield before is not None
    finally:
        if before is not None:
            os.sched_setscheduler(0, *before)
        if collecting:
            gc.enable()


def _prioritised() -> "tuple[int, os.sched_param] | None":
    """Scheduling of this thread before it was given priority; None where that is not allowed."""
    if not hasattr(os, "SCHED_FIFO"):
        return None
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:
        return None
    return before
