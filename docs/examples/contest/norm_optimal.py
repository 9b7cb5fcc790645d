"""Norm-optimal learning (Algorithm 3) with the nominal model of the loop.

The model is that of the nominal joint, or T_u of thesis (9.12) for every motor of a robot. Weights
of correction and change over that of the error: 1e-2 and 0.1, chosen on public tasks.
"""

import numpy as np

from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.system import System
from armside.ilc.models.two_mass import PdController, TwoMassJoint, TwoMassLoop


def nominal_model(task):
    if task.track != "joint":
        return System(np.array([0.0] * 5 + [0.5083]), np.array([1.0, -0.4884]), task.sample_time)
    names = ("Kp", "Kd", "Tf")
    controller = PdController(**{name: task.nominal[name] for name in names})
    joint = TwoMassJoint(**{k: v for k, v in task.nominal.items() if k not in names})
    return TwoMassLoop(joint=joint, controller=controller, sample_time=task.sample_time).T_motor


class Entry:
    def start(self, task):
        N, n = task.reference.shape
        weights = QuadraticCriterion(correction=1e-2, change=0.1)
        self.law = NormOptimal(T_u=nominal_model(task), n_samples=N, n_columns=n, criterion=weights)
        return np.zeros((N, n))

    def update(self, records):
        return self.law(records.correction, records.error)
