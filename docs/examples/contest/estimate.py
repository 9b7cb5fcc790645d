"""Learn the tool's path as estimated from encoders and IMU, on the springs of the first run.

What `armside laser --measure estimate` does (docs/estimation.md), from the task's nominal robot.
For the track imu; `tracker.py` is the same by the tracker.
"""

import numpy as np

from armside.sim.contest.nominal import cut_of, pass_of
from armside.sim.laser.experiment import prepare
from armside.sim.laser.tool_measure import Source, ToolPath

SOURCE = Source.ESTIMATE


class Entry:
    def start(self, task):
        self.reference, self.memory = task.reference, None
        self.set_up = ToolPath(source=SOURCE).prepare(prepare(cut_of(task.nominal)))
        self.output = None
        return np.zeros_like(task.reference)

    def update(self, records):
        run = pass_of(self.reference, vars(records))
        if self.output is None:
            self.output = self.set_up(run)
            self.law = self.output.law
        error = self.output.reference - self.output(run)
        correction, self.memory = self.law.step(records.correction, error, self.memory)
        return correction
