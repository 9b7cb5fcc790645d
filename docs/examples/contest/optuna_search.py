"""Optuna's search (TPE) of the design within the runs of the task, else as `random_search.py`.

Its objective is what a design leaves of the best error so far. Needs the extra `armside[tuning]`.
"""

import numpy as np
import optuna

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.heuristic import Heuristic


class Entry:
    def start(self, task):
        self.left, self.sample_time = task.runs - 1, task.sample_time
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        sampler = optuna.samplers.TPESampler(seed=task.seed)
        self.study, self.best = optuna.create_study(sampler=sampler), None
        return np.zeros_like(task.reference)

    def propose(self):
        self.trial = self.study.ask()
        gamma = self.trial.suggest_float("gamma", 0.1, 1.5)
        return (
            gamma,
            self.trial.suggest_int("delta", 0, 25),
            self.trial.suggest_float("part", 0.0, 1.0),
        )

    def tell(self, size):
        self.study.tell(self.trial, size / self.best[0])

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
