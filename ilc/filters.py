"""Filters along a finished record: zero-phase low-pass Q, and the time shift q^delta.

The whole record is available when it is filtered, so filters need not be causal. Signals have
shape (N, n); a design variable is one number for all columns or one for each column. Filters run
as recursions in O(N); importing this module does not import scipy.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, check_numbers

from .records import as_whole, records

PerColumn = float | tuple[float, ...]
"""One value for all columns (motors), or one value for each."""


class Edge(Enum):
    """Extension of a record beyond its ends that a filter assumes."""

    ODD = "odd"
    """The record mirrored through its end points, 3 * order samples: MATLAB's filtfilt."""
    REST = "rest"
    """Zero before the start and after the end; contracts best where a record begins at rest."""


class End(Enum):
    """Samples that a shift moves in beyond the end of the record."""

    HOLD = "hold"
    """The last (first) value again. Keeps the iteration a contraction with `Edge.ODD`."""
    ZERO = "zero"


class RecordFilter(Protocol):
    """A linear filter of finished records, and its response on records without ends."""

    def __call__(self, signal: Array, /) -> Array:
        """Filter each column; shape (N, n) in and out."""
        ...

    def response(self, omega: ArrayLike) -> NDArray[Any]:
        """Q(e^{j omega}) at the normalised frequencies omega [rad/sample]."""
        ...

    def check(self, n_samples: int, n_columns: int) -> None:
        """Raise ValueError if records of this shape cannot be filtered."""
        ...


@dataclass(frozen=True)
class AllPass:
    """Q = 1."""

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        return signal.copy()

    def response(self, omega: ArrayLike) -> Array:
        return np.ones(np.shape(omega))

    @property
    def poles(self) -> NDArray[np.complex128]:
        """None."""
        return np.zeros(0, dtype=np.complex128)

    def check(self, n_samples: int, n_columns: int) -> None:
        """Accept every shape."""


_DECAYED = 1e-16  # of a pass at rest beyond the record
_MOST_RINGING = 1_000_000
ALL_PASS: RecordFilter = AllPass()


@dataclass(frozen=True)
class ZeroPhaseButterworth:
    """Butterworth low-pass applied forwards and backwards: no phase, magnitude |B|^2.

    At the cutoff the gain is 1/2, not 1/sqrt(2). Thesis 8.4.2 and 9.2.2.
    """

    cutoff: PerColumn
    """[Hz], above zero and below the Nyquist frequency."""
    sample_time: float
    """[s]."""
    order: int = 2
    """Order of one pass, 1 to 4."""
    edge: Edge = Edge.ODD

    def __post_init__(self) -> None:
        check_numbers(self, "sample_time", "order")
        check_numbers(self, "cutoff", several=True, nan=True)
        if not (np.isfinite(self.sample_time) and self.sample_time > 0.0):
            raise ValueError(f"sample_time must be > 0 s, got {self.sample_time}")
        if self.order not in (1, 2, 3, 4):
            raise ValueError(f"order must be 1, 2, 3 or 4, got {self.order}")
        if np.ndim(self.cutoff) == 1:
            object.__setattr__(self, "cutoff", tuple(float(f) for f in np.ravel(self.cutoff)))
        nyquist = 0.5 / self.sample_time
        for cutoff in as_tuple(self.cutoff):
            if not 0.0 < cutoff < nyquist:  # NaN is refused as well
                band = f"above 0 and below the Nyquist frequency {nyquist:g} Hz"
                raise ValueError(f"cutoff must be {band}, got {cutoff:g}")

    def check(self, n_samples: int, n_columns: int) -> None:
        check_columns("cutoff", self.cutoff, n_columns)
        lowest = min(as_tuple(self.cutoff))
        if self.edge is Edge.REST and (ringing := self._ringing(lowest)) > _MOST_RINGING:
            needed = f"{_MOST_RINGING} samples with Edge.REST"
            raise ValueError(f"cutoff {lowest:g} Hz rings for {ringing} samples, above {needed}")
        if n_samples <= (pad := self._pad()):
            needed = f"longer than the pad of {pad} samples"
            raise ValueError(f"the record must be {needed}, got {n_samples}")

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        self.check(*signal.shape)
        cutoffs = as_tuple(self.cutoff)
        if len(set(cutoffs)) == 1:
            return self._filter(signal, cutoffs[0])
        filtered = np.empty_like(signal)
        for cutoff in set(cutoffs):
            columns = [i for i, f in enumerate(cutoffs) if f == cutoff]
            filtered[:, columns] = self._filter(signal[:, columns], cutoff)
        return filtered

    def response(self, omega: ArrayLike) -> Array:
        """Real and >= 0. Shape of omega, with a last axis for the columns if cutoffs differ."""
        response = [self._response(f, np.asarray(omega)) for f in as_tuple(self.cutoff)]
        return response[0] if len(response) == 1 else np.stack(response, axis=-1)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles inside the unit circle, each for both passes, of all columns together."""
        roots = [
            np.roots(a)
            for cutoff in sorted(set(as_tuple(self.cutoff)))
            for _, a in butterworth(cutoff, self.sample_time, self.order)
        ]
        return np.concatenate(2 * roots).astype(np.complex128)

    def _response(self, cutoff: float, omega: Array) -> Array:
        q_inverse = np.exp(-1j * omega)
        magnitude = np.ones(omega.shape)
        for b, a in butterworth(cutoff, self.sample_time, self.order):
            magnitude = magnitude * abs(np.polyval(b[::-1], q_inverse))
            magnitude = magnitude / abs(np.polyval(a[::-1], q_inverse))
        return magnitude**2

    def _ringing(self, cutoff: float) -> int:
        """Samples until one pass at rest has decayed to rounding."""
        sections = butterworth(cutoff, self.sample_time, self.order)
        slowest = max(float(np.abs(np.roots(a)).max()) for _, a in sections)
        return int(np.ceil(np.log(_DECAYED) / np.log(slowest))) if slowest > 0.0 else 0

    def _pad(self) -> int:
        return 3 * self.order if self.edge is Edge.ODD else 0

    def _filter(self, signal: Array, cutoff: float) -> Array:
        sections = butterworth(cutoff, self.sample_time, self.order)
        if self.edge is Edge.REST:  # the forward pass rings beyond the end of the record
            after = np.zeros((self._ringing(cutoff), signal.shape[1]))
            forwards = _one_pass(sections, np.concatenate((signal, after)), False)
            return _one_pass(sections, forwards[::-1], False)[::-1][: len(signal)]
        pad = self._pad()
        before = 2.0 * signal[0] - signal[pad:0:-1]
        after = 2.0 * signal[-1] - signal[-2 : -pad - 2 : -1]
        padded = np.concatenate((before, signal, after))
        forwards = _one_pass(sections, padded, True)
        return _one_pass(sections, forwards[::-1], True)[::-1][pad:-pad]


@records("signal")
def shift(signal: Array, delta: int | tuple[int, ...], end: End = End.HOLD) -> Array:
    """q^delta: (q^delta e)(t) = e(t + delta), shape (N, n). Thesis (8.12), (9.2).

    delta > 0 looks ahead. `end` sets the samples that are moved in beyond the record.
    """
    n_samples = len(signal)
    deltas = as_tuple(delta)
    check_columns("delta", delta, signal.shape[1])
    check_shift(delta, n_samples)
    # Row index of each (sample, column).
    source = np.arange(n_samples)[:, None] + as_whole(deltas, "delta")
    rows = np.broadcast_to(source.clip(0, n_samples - 1), signal.shape)
    shifted = np.take_along_axis(signal, rows, axis=0)
    if end is End.ZERO:
        shifted = np.where((source >= 0) & (source < n_samples), shifted, 0.0)
    return shifted


def check_shift(delta: int | tuple[int, ...], n_samples: int) -> None:
    """Raise ValueError if a shift is as long as the record."""
    for value in as_whole(as_tuple(delta), "delta").tolist():
        if abs(value) >= n_samples:
            record = f"the record of {n_samples} samples"
            raise ValueError(f"delta must stay within {record}, got {value:g}")


def check_columns(name: str, value: PerColumn, n_columns: int) -> None:
    """Raise ValueError if a design variable does not fit the columns of a record."""
    given = len(as_tuple(value))
    if given not in (1, n_columns):
        raise ValueError(f"{name} must be one value or one for each of {n_columns}, got {given}")


def as_tuple(value: PerColumn) -> tuple[float, ...]:
    """One value or several, as a tuple."""
    return value if isinstance(value, tuple) else (value,)


Section = tuple[Array, Array]
"""(b, a) in powers of q^-1, at most second order, a[0] = 1, static gain 1."""


def butterworth(cutoff: float, sample_time: float, order: int) -> list[Section]:
    """Low-pass as sections of order 2 or 1: bilinear transform, prewarped at the cutoff.

    Sections, because the coefficients of one high-order polynomial lose digits at low cutoffs.
    """
    # Analogue poles on the left half of a circle; each pair p, p* becomes one section.
    warped = np.tan(np.pi * cutoff * sample_time)
    angles = np.pi * (2.0 * np.arange((order + 1) // 2) + order + 1.0) / (2.0 * order)
    sections = []
    for pole in warped * np.exp(1j * angles):
        real = abs(pole.imag) < 1e-9 * warped
        degree = 1 if real else 2
        z = (1.0 + pole) / (1.0 - pole)
        a = np.array([1.0, -z.real]) if real else np.array([1.0, -2.0 * z.real, abs(z) ** 2])
        # (1 - z)(1 - z*) = a(1) without the cancellation of summing a
        gain = abs(2.0 * pole / (1.0 - pole)) ** degree
        b = np.array([1.0, 1.0]) if real else np.array([1.0, 2.0, 1.0])
        sections.append((b * (gain / 2.0**degree), a))
    return sections


def _one_pass(sections: list[Section], signal: Array, from_steady_state: bool) -> Array:
    """Filter forwards, from rest or from the steady state of the first sample."""
    offset = signal[0] if from_steady_state else 0.0
    filtered = signal - offset
    for b, a in sections:
        filtered = recursion(b, a, filtered)
    return filtered + offset


@records("signal")
def recursion(b: Array, a: Array, signal: Array) -> Array:
    """Filter b/a along the first axis of a signal (N, n); powers of q^-1, a[0] = 1.

    The recursion is a banded triangular system of equations, which LAPACK solves for all columns
    at once in O(N). scipy.signal has the same filter but imports in most of a second.
    """
    from scipy.linalg import lapack  # imported here, for it costs 0.1 s

    n_samples = len(signal)
    moving_average = b[0] * signal
    for lag in range(1, min(len(b), n_samples)):
        moving_average[lag:] += b[lag] * signal[:-lag]
    if len(a) == 1:
        return moving_average
    band = np.repeat(a[:, None], n_samples, axis=1)
    filtered, _ = lapack.dtbtrs(band, moving_average, uplo="L")  # type: ignore[attr-defined]
    return filtered
