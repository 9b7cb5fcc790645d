"""A random design of Q(u + gamma q^delta e) in every step: what tuning has to beat.

Ranges as of the env `armside/IlcTuning-v1`: gain 0.1 to 1.5, shift 0 to 25 samples, 1 to 30 Hz.
"""

import numpy as np

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.heuristic import Heuristic


class Entry:
    def start(self, task):
        self.sample_time, self.rng = task.sample_time, np.random.default_rng(task.seed)
        return np.zeros_like(task.reference)

    def update(self, records):
        Q = ZeroPhaseButterworth(np.exp(self.rng.uniform(0.0, np.log(30.0))), self.sample_time)
        gamma, delta = self.rng.uniform(0.1, 1.5), int(self.rng.integers(26))
        return Heuristic(Q=Q, gamma=gamma, delta=delta)(records.correction, records.error)
