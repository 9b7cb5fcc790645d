"""Conversions between models: ours, those of scipy.signal and of the package control.

A transfer function is returned where its coefficients hold enough digits. `realise` makes an
orthonormal state-space form of systems, well conditioned however close together poles lie: poles
of one input that share a denominator are a cascade of all-pass sections, whose states are
orthonormal for a white input (the basis of Takenaka and Malmquist, in real form after Wahlberg);
the output matrix is fitted to the impulse response. A companion form would lose a digit for each
slow pole.
"""

from typing import Any

import numpy as np

from armside.arrays import Array

from .blocks import Realisation
from .peak import AllPassPhase
from .state_space import StateSpace
from .system import System, controller_form, state_space_to_system
from .system_matrix import SystemMatrix

Matrices = tuple[Array, Array, Array, Array]
_KEPT = 1e-7
"""Largest error of a response by its coefficients, relative to the largest response."""


def as_state_space(model: Any, sample_time: float | None = None) -> StateSpace:
    """From a model of scipy.signal or control, or of ours; several inputs and outputs.

    Models in continuous time are sampled with a zero-order hold and need a sample_time [s].

    Raises ValueError for something else, a model that is not causal, or a sample time that is
    missing or differs.
    """
    if isinstance(model, StateSpace):
        return model
    if isinstance(model, System | SystemMatrix):
        entries = model.entries if isinstance(model, SystemMatrix) else ((model,),)
        rows = [[_of_system(system) for system in row] for row in entries]
        return StateSpace(*_stacked(rows), model.sample_time)
    dt, known = _sampling(model), _matrices(model)
    if dt == 0.0:
        if sample_time is None:
            raise ValueError("a model in continuous time needs a sample_time")
        return StateSpace.from_continuous(*known, sample_time)
    if sample_time is not None and not np.isclose(dt, sample_time, rtol=1e-9):
        raise ValueError(f"the model has a sample time of {dt:g} s, got {sample_time:g} s")
    return StateSpace(*known, dt)


def as_system(model: Any) -> System:
    """System from a `System`, a `StateSpace`, or a discrete model of scipy.signal or control."""
    if isinstance(model, System):
        return model
    if _sampling(model, "dt" if hasattr(model, "dt") else "sample_time") == 0.0:
        raise ValueError(f"model must be discrete with a sample time in s, got dt = {model.dt}")
    known = as_state_space(model)
    if (known.n_inputs, known.n_outputs) != (1, 1):
        given = f"{known.n_inputs} and {known.n_outputs}"
        raise ValueError(f"model must have one input and one output, got {given}")
    if hasattr(model, "A"):
        return _coefficients(known)
    ratio = model if hasattr(model, "num") else model.to_tf()
    num, den = ((p[0][0] if _is_of_control(model) else p) for p in (ratio.num, ratio.den))
    return System.from_z(num, den, known.sample_time)


def simplest(model: StateSpace) -> System | StateSpace:
    """One input and one output as a `System`, if its coefficients hold the response."""
    if (model.n_inputs, model.n_outputs) != (1, 1):
        return model
    try:
        return _coefficients(model)
    except ValueError:
        return model


def _coefficients(model: StateSpace) -> System:
    found = state_space_to_system(model.A, model.B, model.C, model.sample_time)
    b = found.b + model.feedthrough[0, 0] * found.a
    system = System(b, found.a, model.sample_time)
    omega = AllPassPhase(model.all_poles).grid()
    with np.errstate(divide="ignore", invalid="ignore"):  # poles on the unit circle
        known, kept = model.response(omega)[:, 0, 0], system.response(omega)
    finite = np.isfinite(known) & np.isfinite(kept)
    lost = np.abs(kept - known)[finite].max(initial=0.0)
    if not lost <= _KEPT * np.abs(known)[finite].max(initial=0.0):
        raise ValueError(
            f"polynomials of order {len(model.A)} miss the response of the model by {lost:.1g}: "
            "keep it in state space (as_state_space)"
        )
    return system


def _sampling(model: Any, name: str = "dt") -> float:
    """Sample time [s]; 0 for continuous time."""
    if not hasattr(model, name):
        kinds = "System, a StateSpace, or a model of scipy.signal or control"
        raise ValueError(f"model must be a {kinds}, got {type(model).__name__}")
    dt = getattr(model, name)
    dt = 0.0 if dt is None and not _is_of_control(model) else dt
    if dt is None or isinstance(dt, bool):
        raise ValueError(f"model must be continuous or have a sample time in s, got dt = {dt}")
    return float(dt)


def _is_of_control(model: Any) -> bool:
    return hasattr(model, "ninputs")


def _matrices(model: Any) -> Matrices:
    if hasattr(model, "A"):
        return model.A, model.B, model.C, model.D
    if hasattr(model, "to_ss") and not _is_of_control(model):
        return _matrices(model.to_ss())
    if not hasattr(model, "num"):
        raise ValueError(f"model must have matrices or polynomials, got {type(model).__name__}")
    entries = zip(model.num, model.den, strict=True)
    rows = [zip(num, den, strict=True) for num, den in entries]
    return _stacked([[controller_form(*each) for each in row] for row in rows])


def _of_system(system: System) -> Matrices:
    """b and a in powers of q^-1, padded to one length, are polynomials in descending powers."""
    size = max(len(system.b), len(system.a))
    return controller_form(*(np.pad(p, (0, size - len(p))) for p in (system.b, system.a)))


def _stacked(rows: list[list[Matrices]]) -> Matrices:
    """y_i = sum_j G_ij u_j, the states of all entries one after another."""
    from scipy.linalg import block_diag

    p, m = len(rows), len(rows[0])
    all_entries = [(i, j, rows[i][j]) for i in range(p) for j in range(m)]
    A: Array = np.asarray(block_diag(*(entry[0] for _, _, entry in all_entries)), np.float64)
    B, C, D, first = np.zeros((len(A), m)), np.zeros((p, len(A))), np.zeros((p, m)), 0
    for i, j, (block, drive, output, direct) in all_entries:
        states = slice(first, first := first + len(block))
        B[states, j], C[i, states], D[i, j] = drive[:, 0], output[0], direct[0, 0]
    return A, B, C, D


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
