"""Plants and records for tests of laws, and what is left of an error."""

import numpy as np

from armside.ilc import Edge, ZeroPhaseButterworth, learn
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.system import System
from armside.ilc.models.two_mass import TwoMassLoop

N, T_S = 90, 0.004
ARX = System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], T_S)
"""Servo of the thesis's large robot, (9.12)."""
T_MOTOR, T_ARM = TwoMassLoop().T_motor, TwoMassLoop().T_arm


def low_pass(cutoff=20.0, edge=Edge.REST):
    return ZeroPhaseButterworth(cutoff, T_S, edge=edge)


def error_norms(plant, law, reference, iterations, **options):
    trials = learn(plant, law, reference, iterations, divergence_ratio=np.inf, **options)
    return np.array([two_norm(trial.error)[0] for trial in trials])


def bump(n=N, columns=1):
    """A record that begins and ends at rest."""
    t = np.linspace(0, 1, n)
    shape = np.exp(-(((t - 0.45) / 0.12) ** 2)) - 0.5 * np.exp(-(((t - 0.6) / 0.05) ** 2))
    return shape[:, None] * np.arange(1, columns + 1)
