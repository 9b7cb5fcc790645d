"""Linear, time-invariant, discrete systems in the backward shift: y = b(q^-1) / a(q^-1) u.

Leading zeros of b are the delay, and records are filtered directly. Systems from continuous
models: `zoh` and `tustin`; from other packages: `conversion.as_system`.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeVar, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, shown

from ..filters import recursion
from ..records import as_number, as_real, records


def is_stable(a: Array) -> bool:
    """All roots of a[0] z^n + ... + a[n] are inside the unit circle.

    They are if and only if the matrix of Schur and Cohn is positive definite. Its leading minors
    are computed in whole numbers (Bareiss), for close, slow poles differ by less than rounding.
    """
    exact = [Fraction(float(p)) for p in np.trim_zeros(a, "b")]
    scale = max(p.denominator for p in exact)  # a power of two
    c, n = [int(p * scale) for p in exact], len(exact) - 1
    M = [
        [
            sum(c[i - k] * c[j - k] - c[n - i + k] * c[n - j + k] for k in range(min(i, j) + 1))
            for j in range(n)
        ]
        for i in range(n)
    ]
    before = 1
    for k in range(n):
        pivot = M[k][k]  # the leading minor of order k + 1
        if pivot <= 0:
            return False
        for i in range(k + 1, n):
            for j in range(k + 1, n):
                M[i][j] = (M[i][j] * pivot - M[i][k] * M[k][j]) // before
        before = pivot
    return True


Complex = NDArray[np.complex128]


def unit_circle(omega: ArrayLike) -> Complex:
    """z = e^{j omega} for omega [rad/sample]."""
    return np.exp(1j * np.asarray(omega, dtype=np.float64)).astype(np.complex128)


@dataclass(frozen=True, eq=False)
class System:
    """y(t) = b0 u(t) + b1 u(t-1) + ... - a1 y(t-1) - ...; causal by construction.

    b, a: powers of q^-1, leading zeros of b are the delay, a[0] = 1 after construction.
    """

    b: Array
    a: Array
    sample_time: float
    """[s]."""

    def __post_init__(self) -> None:
        as_number(self.sample_time, "sample_time", 0.0)
        b, a = polynomial(self.b, "b"), polynomial(self.a, "a")
        if a[0] == 0.0:
            raise ValueError(
                "the model is not causal: the denominator in powers of q^-1 must start with a "
                f"coefficient that is not 0, got {a}"
            )
        for name, p in (("b", b / a[0]), ("a", a / a[0])):
            p.setflags(write=False)
            object.__setattr__(self, name, p)

    @classmethod
    def from_z(cls, num: ArrayLike, den: ArrayLike, sample_time: float) -> "System":
        """From polynomials in descending powers of z (or q). ValueError if it is not causal."""
        b = np.trim_zeros(polynomial(num, "num"), "f")
        a = np.trim_zeros(polynomial(den, "den"), "f")
        if len(b) > len(a):
            raise ValueError(
                f"the model is not causal: numerator degree {len(b) - 1} in q exceeds "
                f"denominator degree {len(a) - 1}"
            )
        return cls(np.concatenate((np.zeros(len(a) - len(b)), b)), a, sample_time)

    @property
    def poles(self) -> Complex:
        """Poles in the z plane that are not at the origin."""
        return np.roots(self.a).astype(np.complex128)

    @property
    def all_poles(self) -> Complex:
        """Poles, those at the origin that a longer numerator needs included."""
        delays = max(0, len(self.b) - len(self.a))
        return np.concatenate((np.zeros(delays), self.poles)).astype(np.complex128)

    @property
    def is_stable(self) -> bool:
        """All poles inside the unit circle, decided exactly for the coefficients as stored."""
        return is_stable(self.a)

    @property
    def static_gain(self) -> float:
        return float(self.b.sum() / self.a.sum())

    @property
    def delay(self) -> int:
        """Relative degree [samples]."""
        return int(np.flatnonzero(self.b)[0]) if self.b.any() else 0

    def response(self, omega: ArrayLike) -> Complex:
        """Frequency response at omega [rad/sample]."""
        q_inverse = 1.0 / unit_circle(omega)
        ratio = np.polyval(self.b[::-1], q_inverse) / np.polyval(self.a[::-1], q_inverse)
        return ratio.astype(np.complex128)

    @records("signal")
    def simulate(self, signal: Array) -> Array:
        """Output for the input (N, n), each column on its own, from zero state."""
        return recursion(self.b, self.a, signal)

    @records("signal")
    def adjoint(self, signal: Array) -> Array:
        """T^T e on the finite record (N, n): the time-reversed record filtered, then reversed."""
        return self.simulate(signal[::-1])[::-1]

    @property
    def n_inputs(self) -> int:
        """1: a record with more columns is filtered column by column."""
        return 1

    @property
    def n_outputs(self) -> int:
        return 1

    def impulse(self, n_samples: int) -> Array:
        """Impulse response, shape (n_samples,): the first column of the lifted matrix."""
        return self.simulate(np.eye(n_samples, 1))[:, 0]

    def __mul__(self, other: Union["System", float]) -> "System":
        if isinstance(other, System):
            if not np.isclose(self.sample_time, other.sample_time, rtol=1e-12):
                times = f"{self.sample_time} and {other.sample_time} s"
                raise ValueError(f"systems must have one sample time, got {times}")
            b, a = np.convolve(self.b, other.b), np.convolve(self.a, other.a)
            return System(b, a, self.sample_time)
        return System(self.b * other, self.a, self.sample_time)

    __rmul__ = __mul__

    @property
    def characteristic(self) -> Array:
        """a + b, characteristic polynomial of the closed loop in powers of q^-1."""
        size = max(len(self.a), len(self.b))
        return np.pad(self.a, (0, size - len(self.a))) + np.pad(self.b, (0, size - len(self.b)))

    def feedback(self, name: str = "the closed loop") -> "System":
        """Closed loop G / (1 + G), `name` in messages. Thesis (8.15). ValueError if unstable."""
        a = self.characteristic
        if a[0] == 0.0:
            raise ValueError(f"{name} has no solution: 1 + G is 0 at infinite frequency")
        return require_stable(System(self.b, a, self.sample_time), name)


Stable = TypeVar("Stable")


def require_stable(system: Stable, name: str) -> Stable:
    """Return a stable system; raise ValueError with its name and largest pole otherwise, or for a
    model without poles, which lives on a record alone."""
    model: Any = system
    if not hasattr(model, "is_stable"):
        kind = type(model).__name__
        raise ValueError(f"{name} must be time-invariant, with a frequency response, got {kind}")
    if not model.is_stable:
        largest = np.abs(model.poles).max()
        raise ValueError(f"{name} is unstable: its largest pole has modulus {largest:.6g}, not < 1")
    return system


def zero_order_hold(A: Array, B: Array, sample_time: float) -> tuple[Array, Array]:
    """(A_d, B_d) of x' = A x + B u with u held over each sample; leading axes are batched."""
    from scipy.linalg import expm

    n, m = B.shape[-2:]
    block = np.zeros((*A.shape[:-2], n + m, n + m))
    block[..., :n, :n] = A
    block[..., :n, n:] = B
    transition: Array = np.asarray(expm(block * sample_time), dtype=np.float64)
    return transition[..., :n, :n], transition[..., :n, n:]


def state_space_to_system(A: Array, B: Array, C: Array, sample_time: float) -> System:
    """Transfer operator C (q - A)^-1 B of a discrete system with one input and one output.

    By Markov parameters: the response of the joint of chapter 8 at 4 ms is right to 4e-13, at
    0.25 ms to 1e-13; the difference of polynomials in `scipy.signal.ss2tf` loses it to 9e-11 and
    2e-8 (`tests/ilc/test_systems.py`).
    """
    a: Array = np.poly(A).real.astype(np.float64)
    # b follows from the first n + 1 Markov parameters: b = a * h, cut there.
    markov, x = [0.0], B[:, 0]
    for _ in range(len(A)):
        markov.append(float(C[0] @ x))
        x = A @ x
    return System(np.convolve(a, markov)[: len(A) + 1], a, sample_time)


def zoh(num: ArrayLike, den: ArrayLike, sample_time: float) -> System:
    """Zero-order-hold equivalent of num(s)/den(s), descending powers of s, as MATLAB's c2d."""
    as_number(sample_time, "sample_time", 0.0)
    A, B, C, D = controller_form(num, den)
    strictly_proper = state_space_to_system(*zero_order_hold(A, B, sample_time), C, sample_time)
    b = strictly_proper.b + D[0, 0] * strictly_proper.a
    return System(b, strictly_proper.a, sample_time)


def tustin(num: ArrayLike, den: ArrayLike, sample_time: float) -> System:
    """Bilinear equivalent: s = 2/T (1 - q^-1) / (1 + q^-1).

    That of `scipy.signal.bilinear` without its import, which takes half a second.
    """
    as_number(sample_time, "sample_time", 0.0)
    num, den = polynomial(num, "num"), polynomial(den, "den")
    degree = max(len(num), len(den)) - 1

    def substituted(polynomial: Array) -> Array:
        """(1 + q^-1)^degree times the polynomial at this s."""
        total = np.zeros(degree + 1)
        for power, coefficient in enumerate(polynomial[::-1]):
            term = np.poly(np.concatenate((np.ones(power), -np.ones(degree - power))))
            total += coefficient * (2.0 / sample_time) ** power * term
        return total

    return System(substituted(num), substituted(den), sample_time)


def polynomial(coefficients: ArrayLike, name: str) -> Array:
    """(m,) coefficients of descending powers. ValueError for none, or not finite ones, and for a
    denominator `den` that is 0."""
    p = np.atleast_1d(as_real(coefficients, name))
    if p.ndim != 1 or not p.size or not np.isfinite(p).all():
        raise ValueError(f"{name} must be finite coefficients of shape (m,), got {shown(p)}")
    if name == "den" and not p.any():
        raise ValueError(f"{name} must have a coefficient that is not 0, got {p}")
    return p


def controller_form(num: ArrayLike, den: ArrayLike) -> tuple[Array, Array, Array, Array]:
    """(A, B, C, D) of num / den, descending powers. ValueError for one that is not causal."""
    b, a = np.trim_zeros(polynomial(num, "num"), "f"), np.trim_zeros(polynomial(den, "den"), "f")
    if len(b) > len(a):
        degrees = f"numerator degree {len(b) - 1} exceeds denominator degree {len(a) - 1}"
        raise ValueError(f"the model is not causal: {degrees}")
    b, a = np.pad(b, (len(a) - len(b), 0)) / a[0], a / a[0]
    n = len(a) - 1
    A = np.eye(n, k=-1)
    A[:1] = -a[1:]
    return A, np.eye(n, 1), (b[1:] - b[0] * a[1:])[None], b[:1, None]
