"""Polynomial models of one input and one output, and their one-step prediction errors.

    A(q) y = B(q) / F(q) u(t - n_k) + C(q) / D(q) e        e white

ARX, ARMAX, output error and Box-Jenkins are choices of orders. With v = A y - B / F u the
prediction error is e = D / C v. Ljung, "System Identification", 2nd ed., section 4.2 and (10.53).
"""

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import recursion
from ..models.system import Complex, System
from ..records import records


class Information(Enum):
    """Penalty on the number of coefficients."""

    AIC = "aic"
    BIC = "bic"
    """log(samples) a coefficient: consistent order selection."""


POLYNOMIALS = "abcdf"
_INSIDE = 0.999  # modulus of mirrored zeros of a start: beyond it a predictor forgets no start


@dataclass(frozen=True, kw_only=True)
class Orders:
    """Numbers of coefficients; the leading 1 of a, c, d and f is not counted. nk: delay."""

    nb: int
    nk: int
    na: int = 0
    nc: int = 0
    nd: int = 0
    nf: int = 0

    def __post_init__(self) -> None:
        if min(self.na, self.nc, self.nd, self.nf, self.nk) < 0 or self.nb < 1:
            raise ValueError(f"orders must be >= 0 and nb >= 1, got {self}")

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers of coefficients of a, b, c, d and f."""
        return self.na, self.nb, self.nc, self.nd, self.nf

    @property
    def count(self) -> int:
        return sum(self.sizes)

    @classmethod
    def output_error(cls, nb: int, nf: int, nk: int) -> "Orders":
        """B / F u + e."""
        return cls(nb=nb, nk=nk, nf=nf)

    @classmethod
    def armax(cls, na: int, nb: int, nc: int, nk: int) -> "Orders":
        """A y = B u + C e."""
        return cls(nb=nb, nk=nk, na=na, nc=nc)

    @classmethod
    def box_jenkins(cls, nb: int, nc: int, nd: int, nf: int, nk: int) -> "Orders":
        """B / F u + C / D e."""
        return cls(nb=nb, nk=nk, nc=nc, nd=nd, nf=nf)


@dataclass(frozen=True, eq=False)
class Polynomials:
    """Model with coefficients theta (orders.count,): those of a, b, c, d and f after another."""

    orders: Orders
    theta: Array
    sample_time: float

    @cached_property
    def parts(self) -> dict[str, Array]:
        """Polynomials in powers of q^-1, b with its delay."""
        ends = np.cumsum(self.orders.sizes)[:-1]
        split = dict(zip(POLYNOMIALS, np.split(self.theta, ends), strict=True))
        b = np.concatenate((np.zeros(self.orders.nk), split.pop("b")))
        return {"b": b} | {name: np.append(1.0, value) for name, value in split.items()}

    @property
    def system(self) -> System:
        """From u to y: B / (A F)."""
        p = self.parts
        return System(p["b"], np.convolve(p["a"], p["f"]), self.sample_time)

    @property
    def is_predictor_stable(self) -> bool:
        """C and F have their zeros inside the unit circle."""
        return all(np.abs(np.roots(self.parts[name])).max(initial=0.0) < 1.0 for name in "cf")

    def with_stable_predictor(self, inside: float = _INSIDE) -> "Polynomials":
        """Zeros of C and F beyond the modulus `inside` replaced by their mirror images in the unit
        circle, with that modulus at most."""
        parts = {**self.parts, **{name: _reflected(self.parts[name], inside) for name in "cf"}}
        parts["b"] = np.append(0.0, parts["b"][self.orders.nk :])
        return replace(self, theta=np.concatenate([parts[name][1:] for name in POLYNOMIALS]))

    @records("u", "y")
    def prediction_error(self, u: Array, y: Array) -> Array:
        """e (N, m) of m experiments from rest."""
        p = self.parts
        return recursion(p["d"], p["c"], self._disturbance(u, y))

    @records("u", "y")
    def gradient(self, u: Array, y: Array) -> Array:
        """Derivatives of the prediction error by theta, (N, m, orders.count). Ljung (10.53)."""
        p, v = self.parts, self._disturbance(u, y)
        e = recursion(p["d"], p["c"], v)
        cf, one = np.convolve(p["c"], p["f"]), np.ones(1)
        by = {
            "a": recursion(p["d"], p["c"], y),
            "b": -recursion(p["d"], cf, u),
            "c": -recursion(one, p["c"], e),
            "d": recursion(one, p["c"], v),
            "f": recursion(p["d"], cf, recursion(p["b"], p["f"], u)),
        }
        first = dict.fromkeys(POLYNOMIALS, 1) | {"b": self.orders.nk}
        columns = [
            delayed(by[name], first[name] + i)
            for name, size in zip(POLYNOMIALS, self.orders.sizes, strict=True)
            for i in range(size)
        ]
        return np.stack(columns, axis=2)

    def response_slopes(self, omega: ArrayLike) -> Complex:
        """Derivatives of the response from u to y by theta, (..., orders.count)."""
        back = np.exp(-1j * np.asarray(omega, dtype=np.float64))
        a, f = (np.polyval(self.parts[name][::-1], back) for name in "af")
        G, n = self.system.response(omega), self.orders
        slopes = [-G * back**i / a for i in range(1, n.na + 1)]
        slopes += [back ** (n.nk + i) / (a * f) for i in range(n.nb)]
        slopes += [np.zeros_like(G)] * (n.nc + n.nd)
        slopes += [-G * back**i / f for i in range(1, n.nf + 1)]
        return np.stack(slopes, axis=-1).astype(np.complex128)

    def _disturbance(self, u: Array, y: Array) -> Array:
        """v = A y - B / F u."""
        p = self.parts
        return recursion(p["a"], np.ones(1), y) - recursion(p["b"], p["f"], u)


@records("signal")
def delayed(signal: Array, samples: int) -> Array:
    """The signal that many samples later, from rest."""
    return np.concatenate((np.zeros((samples, signal.shape[1])), signal))[: len(signal)]


def _reflected(polynomial: Array, inside: float) -> Array:
    zeros = np.roots(polynomial)
    size = np.abs(zeros)
    outside = size > inside
    if not outside.any():
        return polynomial
    zeros[outside] = zeros[outside] / size[outside] * np.minimum(1.0 / size[outside], inside)
    return np.poly(zeros).real.astype(np.float64)
