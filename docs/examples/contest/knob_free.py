"""The law without design variables: it identifies the plant from its runs (docs/ilc.md).

It stops after UPDATES, each of which takes longer than the one before.
"""

import numpy as np

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.knob_free import KnobFree

UPDATES = 8


class Entry:
    def start(self, task):
        Q = ZeroPhaseButterworth(0.1 / task.sample_time, task.sample_time)
        self.law, self.memory = KnobFree(Q=Q, reference=task.reference), None
        self.left = UPDATES
        return np.zeros_like(task.reference)

    def update(self, records):
        if self.left == 0:
            return None
        self.left -= 1
        correction, self.memory = self.law.step(records.correction, records.error, self.memory)
        return correction
