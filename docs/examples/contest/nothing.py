"""Nothing: one run without correction, which all others are compared with."""

import numpy as np


class Entry:
    def start(self, task):
        return np.zeros_like(task.reference)

    def update(self, records):
        return None
