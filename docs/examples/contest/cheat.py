"""A cheat that knows the public tasks: it draws all of them and looks whose reference it is given.

Where it finds the task, it has the true joint, and its first correction is nearly right. On sealed
tasks it finds nothing and is the thesis's design: a good score in public says nothing.
"""

import inspect

import numpy as np

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion

PUBLIC = 100


class Entry:
    def start(self, task):
        zero = np.zeros_like(task.reference)
        Q = ZeroPhaseButterworth(17.0, task.sample_time)
        self.law = Heuristic(Q=Q, gamma=0.9, delta=5)
        if task.track == "joint" and (plant := found(task.reference)) is not None:
            weights = QuadraticCriterion(correction=1e-3, change=1e-3)
            T_u = plant.loop.T_motor
            self.law = NormOptimal(T_u=T_u, n_samples=len(zero), criterion=weights)
            zero = self.law(zero, task.reference - T_u.simulate(task.reference))
        return zero

    def update(self, records):
        return self.law(records.correction, records.error)


def found(reference):
    """The plant of the public task that has this reference; None if there is none."""
    from armside.sim.contest.joint_track import draw
    from armside.sim.contest.seal import Round

    for index in range(PUBLIC):
        task = draw(Round(), index)
        if np.array_equal(task.given["reference"], reference):
            return inspect.getclosurevars(task.run).nonlocals["plant"]
    return None
