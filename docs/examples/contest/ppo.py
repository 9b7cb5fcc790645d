"""A policy of PPO that chooses the design of each step from what the motors did in the last one.

The network is that of `armside train` on version 0 of the env (`armside/scripts/studies/tuned`):
5 mm circles at 20 to 60 mm/s on chapter 9's individuals, by the tracker. It sees neither payload
nor shape. For tracks of one contour; it was not trained on tasks of the contest.
"""

from importlib.resources import as_file, files
from types import SimpleNamespace

import numpy as np

from armside.ilc.measures.norms import inf_norm, two_norm
from armside.sim.contest.nominal import cut_of
from armside.sim.laser.experiment import prepare
from armside.sim.tuning.action import Motors, design_of
from armside.sim.tuning.observation import Layout
from armside.sim.tuning.policies import Network


class Entry:
    def start(self, task):
        with as_file(files("armside.scripts.studies") / "tuned" / "policy.npz") as file:
            self.network = Network.load(file)
        self.experiment, self.k = prepare(cut_of(task.nominal)), 0
        return np.zeros_like(task.reference)

    def update(self, records):
        motor_error = records.error * self.experiment.loaded.model.drives.gear
        seen = SimpleNamespace(
            two_norm=two_norm(motor_error),
            inf_norm=inf_norm(motor_error),
            motor_error=motor_error,
            correction=records.correction,
            experiment=self.experiment,
            k=self.k,
            task=None,
        )
        self.k += 1
        action = self.network(Layout().of(seen))
        return design_of(action, Motors.SHARED, 6).law(records.correction, records.error)
