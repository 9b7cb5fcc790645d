"""A digital twin from the ten commissioning cuts, and its correction for an unseen contour.

What `armside commission` and `armside laser --twin` do (docs/twin.md). For the track first.
"""

from armside.sim.contest.nominal import cut_of, pass_of
from armside.sim.twin.commission import commission
from armside.sim.twin.recordings import measured


class Entry:
    def start(self, task):
        runs = [pass_of(cut["reference"], cut) for cut in task.commissioning]
        twin = commission([measured(run, f"cut-{i}") for i, run in enumerate(runs)]).twin
        return twin.correction(cut_of(task.nominal)).correction

    def update(self, records):
        return None
