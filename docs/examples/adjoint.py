"""A learning law from a paper, as a file for `armside learn`: gradient descent without a model.

J. Bolder, S. Kleinendorst, T. Oomen: Data-driven multivariable ILC: enhanced performance by
eliminating L and Q filters. Int. J. Robust and Nonlinear Control 28 (2018) 3728-3751.
"""

import numpy as np


class Adjoint:
    """u + gain J^T e, where J^T e is measured: J is the plant's response from u to y.

    With time reversal T and E_ij, which takes signal j to place i,

        J^T = T (sum over i, j of E_ij J E_ij) T,

    so each pair of an input i and an output j is one run: error j, reversed in time, is added to
    input i, and the change of output j, reversed again, is a part of the gradient. `pairs` is "all"
    (n^2 runs an iteration), or "own" for axes that do not move each other (n runs).

    The iteration converges for a gain below 2 over the largest squared gain of J. Errors keep what
    J does not reach, such as the first samples behind a delay.
    """

    def __init__(self, experiment, reference, gain=0.7, scale=1.0, pairs="all"):
        if pairs not in ("all", "own"):
            raise ValueError(f"pairs must be all or own, got {pairs}")
        self.experiment, self.reference = experiment, reference
        self.gain, self.scale, self.pairs = gain, scale, pairs

    def step(self, correction, error, memory=None):
        measured = self.reference - error
        gradient = np.zeros_like(correction)
        for i in range(error.shape[1]):
            for j in range(error.shape[1]):
                if i == j or self.pairs == "all":
                    added = np.zeros_like(correction)
                    added[:, i] = self.scale * error[::-1, j]
                    change = self.experiment(correction + added) - measured
                    gradient[:, i] += change[::-1, j] / self.scale
        return correction + self.gain * gradient, memory
