"""Orthonormal state-space form of systems: well conditioned however close together poles lie.

Poles of one input that share a denominator are a cascade of all-pass sections, whose states are
orthonormal for a white input (the basis of Takenaka and Malmquist, in real form after Wahlberg);
the output matrix is fitted to the impulse response. A companion form would lose a digit for each
slow pole.

    x(t + 1) = A x(t) + B u(t)        y(t) = C x(t) + D u(t)
"""

import numpy as np

from armside.arrays import Array

from .blocks import Realisation
from .system import System
from .system_matrix import SystemMatrix

_LARGEST = 1.0 - 1e-9  # modulus of a pole; rounding may place one on the unit circle
Section = tuple[Array, Array, Array, float]
"""(A, B, C, D) of one input and one output, [[A, B], [C, D]] orthogonal."""


def realise(T: SystemMatrix, taps: Array, n_samples: int) -> Realisation:
    """State-space form of F T, F the finite impulse response `taps`, exact over n_samples."""
    n = len(T.entries)
    blocks, drives, columns = [], [], []
    D = np.array([[s.b[0] * taps[0] for s in row] for row in T.entries])
    for j in range(n):
        for rows in _sharing([T.entries[i][j] for i in range(n)]):
            systems = {i: T.entries[i][j] for i in rows}
            A, B = all_pass_states(_poles(list(systems.values()), len(taps)))
            states = _impulse(A, B, n_samples - 1)
            C = np.zeros((n, len(A)))
            for i, system in systems.items():
                wanted = np.convolve(system.impulse(n_samples), taps)[1:n_samples]
                C[i] = np.linalg.lstsq(states, wanted)[0]
            blocks.append(A)
            drives.append(np.outer(B, np.eye(n)[j]))
            columns.append(C)
    drives, columns = [np.zeros((0, n)), *drives], [np.zeros((n, 0)), *columns]
    return Realisation.of_blocks(blocks, np.concatenate(drives), np.concatenate(columns, axis=1), D)


def all_pass_states(poles: Array) -> tuple[Array, Array]:
    """(A, B) of orthonormal states with the given poles, conjugate pairs next to each other.

    A A^T + B B^T = 1: the covariance of the states is the identity for white input.
    """
    A, B, C, D = np.zeros((0, 0)), np.zeros(0), np.zeros(0), 1.0
    for section in _sections(poles):
        A2, B2, C2, D2 = section
        size = len(A)
        grown = np.zeros((size + len(A2), size + len(A2)))
        grown[:size, :size], grown[size:, :size], grown[size:, size:] = A, np.outer(B2, C), A2
        A, B = grown, np.concatenate((B, B2 * D))
        C, D = np.concatenate((D2 * C, C2)), D2 * D
    return A, B


def _sections(poles: Array) -> list[Section]:
    """All-pass sections of order 1 for real poles and 2 for pairs, slowest last."""
    sections = []
    for p in sorted(poles[poles.imag >= 0.0], key=abs):
        p = p * min(1.0, _LARGEST / max(abs(p), 1e-300))
        if p.imag == 0.0:
            a = float(p.real)
            s = np.sqrt((1.0 - a) * (1.0 + a))
            sections.append((np.array([[a]]), np.array([s]), np.array([s]), -a))
            continue
        # z^2 - b (1 - c) z - c, c = -|p|^2
        square = abs(p) ** 2
        b = 2.0 * p.real / (1.0 + square)
        s, r = np.sqrt((1.0 - b) * (1.0 + b)), np.sqrt((1.0 - square) * (1.0 + square))
        A = np.array([[b, -square * s], [s, square * b]])
        sections.append((A, r * np.array([s, -b]), np.array([0.0, r]), square))
    return sections


def _sharing(column: list[System]) -> list[list[int]]:
    """Outputs of one input, grouped by the denominator of their system; zeros are left out."""
    groups: dict[bytes, list[int]] = {}
    for i, system in enumerate(column):
        if system.b.any():
            groups.setdefault(np.trim_zeros(system.a, "b").tobytes(), []).append(i)
    return list(groups.values())


def _poles(systems: list[System], n_taps: int) -> Array:
    """Poles of systems with one denominator, those at 0 that their numerators need included."""
    a = np.trim_zeros(systems[0].a, "b")
    lags = max(len(np.trim_zeros(system.b, "b")) for system in systems) + n_taps - 2
    delays = max(0, lags - (len(a) - 1))
    return np.concatenate((np.zeros(delays, dtype=complex), np.roots(a).astype(complex)))


def _impulse(A: Array, B: Array, n_samples: int) -> Array:
    """States (n_samples, n) at samples 1, 2, ... after an impulse, by doubling."""
    states, power = B[None], A
    while len(states) < n_samples:
        states = np.concatenate((states, states @ power.T))
        power = power @ power
    return states[:n_samples]
