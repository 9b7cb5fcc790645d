"""Benchmark of commissioning: time on one core and on all, and peak memory."""

import os
from collections.abc import Collection, Sequence
from dataclasses import replace

from armside.sim.robot.run import cores
from armside.sim.robot.spread import Drawn
from armside.sim.twin import commission as commissioning
from armside.sim.twin.commission import plan, recorded

from ._timing import Row, interleaved, peak_memory

CUTS = 4
ROBOT = Drawn(1004)


def measured() -> Sequence[Row]:
    """Identification of a twin from recorded cuts on all cores, against one core."""
    cuts = [
        recorded(replace(cut, individual=ROBOT), f"cut-{i + 1}", i)
        for i, cut in enumerate(plan(CUTS))
    ]
    every = os.sched_getaffinity(0)

    def on(allowed: Collection[int]) -> None:
        # Threads that are started later inherit it.
        os.sched_setaffinity(0, allowed)
        try:
            commissioning.commission(cuts)
        finally:
            os.sched_setaffinity(0, every)

    alone = [min(every)]
    ours, theirs = interleaved([lambda: on(every), lambda: on(alone)], repeats=3)
    name = f"commissioning from {CUTS} cuts, {cores()} cores, peak {peak_memory():.2f} GB"
    return [Row(name, ours, "one core", theirs)]
