"""Records for tests of laws, and what is left of an error."""

import numpy as np

from armside.ilc import learn
from armside.ilc.measures.norms import two_norm

N = 90


def error_norms(plant, law, reference, iterations, **options):
    trials = learn(plant, law, reference, iterations, divergence_ratio=np.inf, **options)
    return np.array([two_norm(trial.error)[0] for trial in trials])


def bump(n=N, columns=1):
    """A record that begins and ends at rest."""
    t = np.linspace(0, 1, n)
    shape = np.exp(-(((t - 0.45) / 0.12) ** 2)) - 0.5 * np.exp(-(((t - 0.6) / 0.05) ** 2))
    return shape[:, None] * np.arange(1, columns + 1)
