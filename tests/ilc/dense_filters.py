"""Filters of records as dense matrices, by formulas of their own: references of the tests of laws.

A record (N, n) is a vector with samples first and motors within a sample.
"""

from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import butter, freqz, sosfilt, sosfiltfilt

from .random_cases import T_S, entries_of


def shifted(n_samples, delta, hold=True):
    """q^delta, (N, N)."""
    source = np.arange(n_samples) + delta
    S = np.eye(n_samples)[np.clip(source, 0, n_samples - 1)]
    return S if hold else S * ((source >= 0) & (source < n_samples))[:, None]


def low_pass(n_samples, cutoff, rest=False):
    """Butterworth of second order forwards and backwards, (N, N)."""
    sos: Any = butter(2, cutoff, fs=1.0 / T_S, output="sos")
    if rest:
        padded = np.eye(n_samples + 2000)[:, :n_samples]
        return sosfilt(sos, sosfilt(sos, padded, axis=0)[::-1], axis=0)[::-1][:n_samples]
    return sosfiltfilt(sos, np.eye(n_samples), axis=0, padtype="odd", padlen=6)


def low_pass_gain(omega, cutoff):
    """Its response, real."""
    b, a = butter(2, cutoff, fs=1.0 / T_S)
    return np.abs(freqz(b, a, omega)[1]) ** 2


def by_column(matrices):
    """(N n, N n) of one matrix (N, N) for each motor."""
    n, n_samples = len(matrices), len(matrices[0])
    full = np.zeros((n_samples, n, n_samples, n))
    for j, M in enumerate(matrices):
        full[:, j, :, j] = M
    return full.reshape(n_samples * n, n_samples * n)


def response(T, omega) -> Any:
    """(M, n, n) at omega (M,), by scipy."""
    rows = [[freqz(s.b, s.a, omega)[1] for s in row] for row in entries_of(T)]
    return np.moveaxis(np.array(rows), 2, 0)


def largest_gain(T) -> float:
    """max over frequency of the largest singular value: a grid that resolves poles, refined."""

    def gain(omega):
        return np.linalg.norm(response(T, np.atleast_1d(omega)), 2, axis=(1, 2))

    grid = [np.linspace(0.0, np.pi, 4001)]
    for pole in np.unique(np.concatenate([s.poles for row in entries_of(T) for s in row])):
        width = max(1.0 - abs(pole), 1e-9)
        grid.append(abs(np.angle(pole)) + width * np.tan(np.linspace(-1.57, 1.57, 801)))
    omega = np.unique(np.clip(np.concatenate(grid), 0.0, np.pi))
    i = int(np.argmax(gain(omega)))
    ends = float(omega[max(i - 1, 0)]), float(omega[min(i + 1, len(omega) - 1)])
    found: Any = minimize_scalar(
        lambda w: -float(gain(w)[0]), bounds=ends, method="bounded", options={"xatol": 1e-14}
    )
    return max(float(gain(omega[i])[0]), -float(found.fun))


def tapered(signal):
    """The record and a raised cosine from its last value to its first, (2 N, n)."""
    n = len(signal)
    fade = 0.5 * (1.0 + np.cos(np.pi * np.arange(1, n + 1) / (n + 1)))[:, None]
    return np.vstack((signal, (1.0 - fade) * signal[0] + fade * signal[-1]))[: 2 * n]
