"""Discretisation of continuous systems: zero-order hold and bilinear (Tustin)."""

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_real
from .system import System


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
    """Transfer operator C (q - A)^-1 B of a discrete system with one input and one output."""
    a: Array = np.poly(A).real.astype(np.float64)
    # b follows from the first n + 1 Markov parameters: b = a * h, cut there.
    markov, x = [0.0], B[:, 0]
    for _ in range(len(A)):
        markov.append(float(C[0] @ x))
        x = A @ x
    return System(np.convolve(a, markov)[: len(A) + 1], a, sample_time)


def zoh(num: ArrayLike, den: ArrayLike, sample_time: float) -> System:
    """Zero-order-hold equivalent of num(s)/den(s), descending powers of s, as MATLAB's c2d."""
    A, B, C, D = _controller_form(as_real(num, "num"), as_real(den, "den"))
    strictly_proper = state_space_to_system(*zero_order_hold(A, B, sample_time), C, sample_time)
    return System(strictly_proper.b + D * strictly_proper.a, strictly_proper.a, sample_time)


def tustin(num: ArrayLike, den: ArrayLike, sample_time: float) -> System:
    """Bilinear equivalent: s = 2/T (1 - q^-1) / (1 + q^-1)."""
    num, den = as_real(num, "num"), as_real(den, "den")
    degree = max(len(num), len(den)) - 1

    def substituted(polynomial: Array) -> Array:
        """(1 + q^-1)^degree times the polynomial at this s."""
        total = np.zeros(degree + 1)
        for power, coefficient in enumerate(polynomial[::-1]):
            term = np.poly(np.concatenate((np.ones(power), -np.ones(degree - power))))
            total += coefficient * (2.0 / sample_time) ** power * term
        return total

    return System(substituted(num), substituted(den), sample_time)


def _controller_form(num: Array, den: Array) -> tuple[Array, Array, Array, float]:
    if len(num) > len(den):
        degrees = f"numerator degree {len(num) - 1} in s exceeds denominator degree {len(den) - 1}"
        raise ValueError(f"the model is not causal: {degrees}")
    num = np.concatenate((np.zeros(len(den) - len(num)), num)) / den[0]
    den = den / den[0]
    n = len(den) - 1
    A = np.eye(n, k=-1)
    A[0] = -den[1:]
    return A, np.eye(n, 1), (num[1:] - num[0] * den[1:])[None], float(num[0])
