"""Random search of the design within the runs of the task: each run tries one from the best so far.

Designs as of `random_design.py`. The last run is the best again. What is compared is the motors'
error, each over its first.
"""

import numpy as np

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.heuristic import Heuristic


class Entry:
    def start(self, task):
        self.left, self.sample_time = task.runs - 1, task.sample_time
        self.rng, self.best = np.random.default_rng(task.seed), None
        return np.zeros_like(task.reference)

    def propose(self):
        return self.rng.uniform(0.1, 1.5), int(self.rng.integers(26)), self.rng.uniform(0.0, 1.0)

    def tell(self, size):
        pass

    def update(self, records):
        norm = np.linalg.norm(records.error, axis=0)
        if self.best is None:
            self.first = np.maximum(norm, 1e-12)
        size = float(np.sqrt(np.mean((norm / self.first) ** 2)))
        if self.best is not None:
            self.tell(size)
        if self.best is None or size < self.best[0]:
            self.best = size, records.correction, records.error
        self.left -= 1
        if self.left == 0:
            return self.best[1]
        gamma, delta, part = self.propose()
        Q = ZeroPhaseButterworth(float(np.exp(part * np.log(30.0))), self.sample_time)
        return Heuristic(Q=Q, gamma=gamma, delta=delta)(self.best[1], self.best[2])
