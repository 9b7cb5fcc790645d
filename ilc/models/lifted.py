"""Linear models on finite records, y = T u and its adjoint: the interface, and models without
states.

`System`, `SystemMatrix`, `StateSpace` and `ImpulseResponse` are time-invariant and have a
frequency response as well; `TimeVarying` and `LiftedModel` live on the record. A model of one's
own needs the four members of `RecordModel`; laws and finite-record analysis ask for nothing else.
"""

from dataclasses import dataclass
from typing import Any, Protocol, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_real, records
from .system import Complex


class RecordModel(Protocol):
    """Linear map T of records at rest before, from n_inputs to n_outputs columns."""

    @property
    def n_inputs(self) -> int: ...
    @property
    def n_outputs(self) -> int: ...

    def simulate(self, signal: Array, /) -> Array:
        """T u, shape (N, n_outputs), for u of shape (N, n_inputs)."""
        ...

    def adjoint(self, signal: Array, /) -> Array:
        """T^T e, shape (N, n_inputs), for e of shape (N, n_outputs)."""
        ...


def is_record_model(model: Any) -> TypeGuard[RecordModel]:
    """The object has the members of a `RecordModel`."""
    return all(hasattr(model, name) for name in ("n_inputs", "n_outputs", "simulate", "adjoint"))


def check_shape(model: "RecordModel", shape: tuple[int, ...], width: int, what: str) -> None:
    """Raise ValueError for a record of another shape than the model's, `width` many `what`."""
    covered = getattr(model, "n_samples", shape[0])
    if shape[0] != covered:
        raise ValueError(f"T_u covers {covered} samples, the record {shape[0]}")
    if shape[1] != width:
        raise ValueError(f"T_u has {width} {what}, the record {shape[1]}")


@dataclass(frozen=True, eq=False)
class ImpulseResponse:
    """y(t) = sum_k h(k) u(t - k), h of shape (M, p, m); zero from sample M on."""

    h: Array
    sample_time: float = 1.0
    """[s]."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sample_time) and self.sample_time > 0.0):
            raise ValueError(f"sample_time must be > 0 s, got {self.sample_time}")
        h = np.array(as_real(self.h, "h"))
        h = h[:, None, None] if h.ndim == 1 else h
        if h.ndim != 3 or 0 in h.shape or not np.isfinite(h).all():
            raise ValueError(f"h must be finite with shape (M,) or (M, p, m), got {h.shape}")
        h.setflags(write=False)
        object.__setattr__(self, "h", h)

    @classmethod
    def from_frequency_response(cls, G: ArrayLike, sample_time: float = 1.0) -> "ImpulseResponse":
        """From G at omega = 2 pi k / P, k = 0 .. P/2 of a period of P samples (even), shape
        (P/2 + 1,) or (P/2 + 1, p, m). The response must have died out within the period.

        Raises ValueError for an impulse response that has not died out.
        """
        values = np.asarray(G, dtype=np.complex128)
        if values.ndim not in (1, 3) or len(values) < 2 or not np.isfinite(values).all():
            raise ValueError(f"G must be finite, (M,) or (M, p, m), M >= 2, got {values.shape}")
        h = np.fft.irfft(values, axis=0)
        last = np.abs(h[-max(1, len(h) // 20) :]).max()
        if not last <= DIED_OUT * np.abs(h).max():
            fraction = last / np.abs(h).max()
            raise ValueError(
                f"the impulse response still has {fraction:.2g} of its largest value at the end of "
                f"the period of {len(h)} samples, allowed is {DIED_OUT:g}: measure a longer period"
            )
        return cls(h, sample_time)

    @property
    def n_inputs(self) -> int:
        return self.h.shape[2]

    @property
    def n_outputs(self) -> int:
        return self.h.shape[1]

    @property
    def is_stable(self) -> bool:
        """True: it ends."""
        return True

    @property
    def poles(self) -> Complex:
        """None but at the origin."""
        return np.zeros(0, dtype=np.complex128)

    @property
    def all_poles(self) -> Complex:
        """At the origin, for each entry that is not 0."""
        lags = [int(np.flatnonzero(c)[-1]) for c in self.h.reshape(len(self.h), -1).T if c.any()]
        return np.zeros(sum(lags), dtype=np.complex128)

    @records("signal")
    def simulate(self, signal: Array) -> Array:
        """Outputs (N, p) for inputs (N, m), from rest."""
        check_shape(self, signal.shape, self.n_inputs, "inputs")
        return _convolved(self.h, signal)

    @records("signal")
    def adjoint(self, signal: Array) -> Array:
        """T^T e, shape (N, m), for e (N, p)."""
        check_shape(self, signal.shape, self.n_outputs, "outputs")
        return _convolved(self.h.swapaxes(1, 2), signal[::-1])[::-1]

    def response(self, omega: ArrayLike) -> Complex:
        """Shape (M, p, m) at omega (M,) [rad/sample]."""
        lag = np.exp(-1j * np.multiply.outer(np.atleast_1d(omega), np.arange(len(self.h))))
        return np.tensordot(lag, self.h, axes=1)


DIED_OUT = 0.01
"""Largest value of an impulse response at the end of its period, relative to its largest."""


def _convolved(h: Array, signal: Array) -> Array:
    n_samples = len(signal)
    length = n_samples + min(len(h), n_samples)
    H = np.fft.rfft(h[:n_samples], length, axis=0)
    U = np.fft.rfft(signal, length, axis=0)
    return np.fft.irfft((H @ U[:, :, None])[:, :, 0], length, axis=0)[:n_samples]


@dataclass(frozen=True, eq=False)
class LiftedModel:
    """y = T u for records laid out sample by sample, columns within a sample; T (N p, N m)."""

    T: Array
    n_inputs: int = 1
    n_outputs: int = 1

    def __post_init__(self) -> None:
        T = np.array(as_real(self.T, "T"))
        columns = self.n_outputs, self.n_inputs
        if T.ndim != 2 or min(columns) < 1 or 0 in T.shape or not np.isfinite(T).all():
            raise ValueError(f"T must be a finite matrix (N p, N m), p, m >= 1, got {T.shape}")
        counts = [divmod(size, n) for size, n in zip(T.shape, columns, strict=True)]
        if counts[0][1] or counts[1][1] or counts[0][0] != counts[1][0]:
            needed = f"(N {self.n_outputs}, N {self.n_inputs})"
            raise ValueError(f"T must have shape {needed} for some N, got {T.shape}")
        T.setflags(write=False)
        object.__setattr__(self, "T", T)

    @property
    def n_samples(self) -> int:
        return len(self.T) // self.n_outputs

    @records("signal")
    def simulate(self, signal: Array) -> Array:
        """Outputs (N, p) for inputs (N, m)."""
        check_shape(self, signal.shape, self.n_inputs, "inputs")
        return (self.T @ signal.ravel()).reshape(-1, self.n_outputs)

    @records("signal")
    def adjoint(self, signal: Array) -> Array:
        """T^T e, shape (N, m), for e (N, p)."""
        check_shape(self, signal.shape, self.n_outputs, "outputs")
        return (self.T.T @ signal.ravel()).reshape(-1, self.n_inputs)
