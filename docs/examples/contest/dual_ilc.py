"""Dual iterative learning: a model and a correction are learned from the same runs.

J.-H. Ewering, A. Papa, S. Ehlers, T. Seel, M. Meindl: Dual iterative learning control for MIMO
dynamics with validation in robotic systems. arXiv 2509.18723.

With y = P(m) v = V m (lifted; P and V are Toeplitz matrices of the impulse response m and of the
input v), the model learns from its own error and the input from that of the task:

    m <- m + (V'V + s_m I)^-1 V' (y - V m)        v <- v + (P'P + s_u I)^-1 P' e

The paper's abstract and a review were read, its equations were not. Taken from general knowledge:
both updates norm-optimal; the weights follow from the data, s_m = 1e-5 and s_u = 0.05 of the
largest squared singular value (bounded by the product of 1- and infinity-norms); the impulse
response ends after TAPS samples; axes have one response each; the first model is one delayed step
that is right at rest.
"""

import numpy as np
from scipy.linalg import solve, toeplitz

TAPS, S_MODEL, S_INPUT, DELAY = 150, 1e-5, 0.05, 3


def lower(first, columns):
    return np.tril(toeplitz(first, np.zeros(columns)))


def largest(matrix):
    absolute = np.abs(matrix)
    return absolute.sum(axis=0).max() * absolute.sum(axis=1).max()


def learned(matrix, error, weight):
    """(M'M + s I)^-1 M' error."""
    normal = matrix.T @ matrix
    normal[np.diag_indices_from(normal)] += weight * largest(matrix)
    return solve(normal, matrix.T @ error, assume_a="pos")


class Entry:
    def start(self, task):
        self.reference = task.reference
        self.models = np.zeros((task.reference.shape[1], TAPS))
        self.models[:, DELAY] = 1.0
        return np.zeros_like(task.reference)

    def update(self, records):
        N, n = records.error.shape
        rest = self.reference[:1]
        v = self.reference - rest + records.correction
        y = self.reference - rest - records.error
        correction = records.correction.copy()
        for i in range(n):
            V = lower(v[:, i], TAPS)
            self.models[i] += learned(V, y[:, i] - V @ self.models[i], S_MODEL)
            P = lower(np.concatenate((self.models[i], np.zeros(N - TAPS))), N)
            correction[:, i] += learned(P, records.error[:, i], S_INPUT)
        return correction
