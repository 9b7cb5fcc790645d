"""Adjoints of filters and first-order laws on the finite record, their real edges included.

<F x, y> = <x, F^T y> for all records. Lanczos iterations need products with a law and its adjoint;
building the matrix of a law needs as many runs of it as a record has numbers.
"""

from functools import singledispatch
from typing import Any

import numpy as np

from armside.arrays import Array

from ..filters import (
    AllPass,
    Edge,
    End,
    ZeroPhaseButterworth,
    as_tuple,
    butterworth,
    recursion,
)
from ..laws.first_order import DType, FirstOrder, MatrixGain, PType
from ..laws.heuristic import Heuristic
from ..laws.model_based import Gradient
from ..laws.norm_optimal import NormOptimal
from ..records import records

Pair = tuple[Array, Array]


@records("signal")
def filter_adjoint(given: Any, signal: Array) -> Array:
    """F^T y for a filter F of records (N, n). Raises TypeError for one without known adjoint.

    A filter of one's own states it by a method `adjoint(signal)`.
    """
    return _of_filter(given, signal)


@records("signal")
def law_adjoint(law: Any, signal: Array) -> Pair:
    """(M_u^T v, M_e^T v) of u_{k+1} = M_u u_k + M_e e_k.

    Raises TypeError for a law without known adjoint; one's own states it by `adjoint(signal)`.
    """
    return _of_law(law, signal)


@singledispatch
def _of_filter(given: Any, signal: Array) -> Array:
    if hasattr(given, "adjoint"):
        return given.adjoint(signal)
    raise TypeError(f"{type(given).__name__} has no adjoint: give it a method adjoint(signal)")


@_of_filter.register
def _(given: AllPass, signal: Array) -> Array:
    return signal


@_of_filter.register
def _(given: PType, signal: Array) -> Array:
    return given.gamma * shift_adjoint(signal, given.delta, given.end)


@_of_filter.register
def _(given: DType, signal: Array) -> Array:
    newer = shift_adjoint(signal, given.delta, given.end)
    older = shift_adjoint(signal, given.delta - 1, given.end)
    return given.gamma_d / given.sample_time * (newer - older)


@_of_filter.register
def _(given: MatrixGain, signal: Array) -> Array:
    return shift_adjoint(signal @ given.gamma, given.delta, given.end)


@_of_filter.register
def _(given: Gradient, signal: Array) -> Array:
    return given.step * given.T_u.simulate(signal)


@_of_filter.register
def _(given: ZeroPhaseButterworth, signal: Array) -> Array:
    if given.edge is Edge.REST:  # F^T F for a pass F: symmetric
        return given(signal)
    columns = np.broadcast_to(as_tuple(given.cutoff), signal.shape[1:])
    back = np.empty_like(signal)
    for cutoff in set(columns.tolist()):
        same = columns == cutoff
        back[:, same] = _odd_adjoint(given, cutoff, signal[:, same])
    return back


def _odd_adjoint(given: ZeroPhaseButterworth, cutoff: float, signal: Array) -> Array:
    """Of cutting, the backward pass, the forward pass and the mirrored ends, in this order."""
    pad, n = 3 * given.order, len(signal)
    sections = butterworth(cutoff, given.sample_time, given.order)
    padded = np.zeros((n + 2 * pad, signal.shape[1]))
    padded[pad:-pad] = signal
    padded = _pass_adjoint(sections, padded[::-1])[::-1]
    padded = _pass_adjoint(sections, padded)
    before, back, after = padded[:pad], padded[pad:-pad].copy(), padded[-pad:]
    back[1 : pad + 1] -= before[::-1]
    back[-pad - 1 : -1] -= after[::-1]
    back[0] += 2.0 * before.sum(axis=0)
    back[-1] += 2.0 * after.sum(axis=0)
    return back


def _pass_adjoint(sections: list[tuple[Array, Array]], signal: Array) -> Array:
    """Of y = F (x - x(0)) + x(0)."""
    back = signal[::-1]
    for b, a in sections:
        back = recursion(b, a, back)
    back = back[::-1].copy()
    back[0] += signal.sum(axis=0) - back.sum(axis=0)
    return back


@records("signal")
def shift_adjoint(signal: Array, delta: int | tuple[int, ...], end: End) -> Array:
    """Adjoint of `shift`: samples that were held are added up at the end of the record."""
    n_samples = len(signal)
    source = np.arange(n_samples)[:, None] + np.asarray(as_tuple(delta))
    source = np.broadcast_to(source, signal.shape)
    inside = (source >= 0) & (source < n_samples)
    kept = signal if end is End.HOLD else np.where(inside, signal, 0.0)
    back = np.zeros(signal.shape)
    rows = source.clip(0, n_samples - 1)
    np.add.at(back, (rows, np.broadcast_to(np.arange(signal.shape[1]), rows.shape)), kept)
    return back


@singledispatch
def _of_law(law: Any, signal: Array) -> Pair:
    if hasattr(law, "adjoint"):
        return law.adjoint(signal)
    raise TypeError(f"{type(law).__name__} has no adjoint: give it a method adjoint(signal)")


@_of_law.register
def _(law: Heuristic, signal: Array) -> Pair:
    back = _of_filter(law.Q, signal)
    return back, shift_adjoint(np.asarray(law.gamma) * back, law.delta, law.end)


@_of_law.register
def _(law: FirstOrder, signal: Array) -> Pair:
    back = _of_filter(law.Q, signal)
    return back, _of_filter(law.L, back)


@_of_law.register
def _(law: NormOptimal, signal: Array) -> Pair:
    """M_u = 1 - H^-1 Wu, M_e = H^-1 T' F' We F, H symmetric."""
    problem = law._problem  # pyright: ignore[reportPrivateUsage]
    solved = problem.solve(signal)
    seen = problem.We * problem.filtered(law.T_u.simulate(solved))
    return signal - problem.Wu * solved, problem.filtered(seen[::-1])[::-1]
