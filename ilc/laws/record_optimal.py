"""Norm-optimal learning with several outputs and inputs on the finite record, matrix-free.

    minimise |F (e_k - T (u - u_k))|_W^2 + rho |S^-1 u|^2 + sigma |S^-1 (u - u_k)|^2

T is the frequency response G applied to a record that is at rest before and after, so products
with T and its transpose are FFTs; conjugate gradients take a few dozen of them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.system import Complex
from ..records import records
from .law import FirstOrderLaw
from .regularised_inverse import Response

_STEPS, _SOLVED = 60, 1e-4


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordOptimal(FirstOrderLaw):
    """Norm-optimal law for errors (N, p) and corrections (N, n)."""

    G: Response
    F: RecordFilter
    """Zero-phase filter that selects the learned part of the error; G: response to corrections."""
    output_weight: tuple[float, ...]
    input_size: tuple[float, ...]
    """(n,), diagonal of S, > 0; weights: (p,), square roots of W's diagonal."""
    correction_weight: float = 1e-3
    change_weight: float = 1e-2
    """rho and sigma, relative to the largest static gain of W^1/2 G S, squared."""
    tolerance: float | None = None
    """Residual at which conjugate gradients end, relative to the right side, or they fail. None:
    at 1e-4 or after 60 steps, which is below what a model of an arm is worth."""

    def __post_init__(self) -> None:
        for name in ("correction_weight", "change_weight"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be >= 0, got {getattr(self, name)}")
        if not self.correction_weight + self.change_weight > 0.0:
            raise ValueError("correction_weight and change_weight must not both be 0")
        if self.tolerance is not None and not 0.0 < self.tolerance < 1.0:
            raise ValueError(f"tolerance must be in (0, 1), got {self.tolerance}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n := len(self.input_size)) != n_columns:
            raise ValueError(f"the law has {n} inputs, the record {n_columns} columns")
        self.F.check(n_samples, n_columns)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        n = len(correction)
        weight, size = np.array(self.output_weight), np.array(self.input_size)
        omega = 2.0 * np.pi * np.fft.rfftfreq(2 * n)
        T = weight[:, None] * self.G.response(omega) * size
        T_H = np.conj(np.swapaxes(T, 1, 2))
        scale = np.linalg.norm(T[0], ord=2) ** 2
        rho, sigma = self.correction_weight * scale, self.change_weight * scale

        def through(response: Complex, signal: Array) -> Array:
            spectrum = np.fft.rfft(signal, 2 * n, axis=0)
            moved = (response @ spectrum[:, :, None])[:, :, 0]
            return np.fft.irfft(moved, 2 * n, axis=0)[:n]

        def normal(step: Array) -> Array:
            seen = self.F(self.F(through(T, step)))
            return through(T_H, seen) + (rho + sigma) * step

        right = through(T_H, self.F(self.F(error * weight))) - rho * correction / size
        return correction + size * _conjugate_gradients(normal, right, self.tolerance)


def _conjugate_gradients(A: Callable[[Array], Array], b: Array, tolerance: float | None) -> Array:
    """x of A x = b. Raises RuntimeError where a given tolerance is not reached."""
    x, r = np.zeros_like(b), b.copy()
    p, power = r.copy(), float(np.vdot(b, b))
    enough = (_SOLVED if tolerance is None else tolerance) ** 2 * power
    for _ in range(_STEPS if tolerance is None else 10 * b.size):
        if power <= enough:
            return x
        Ap = A(p)
        along = power / float(np.vdot(p, Ap))
        x, r = x + along * p, r - along * Ap
        last, power = power, float(np.vdot(r, r))
        p = r + power / last * p
    if tolerance is not None and power > enough:
        reached = np.sqrt(power / np.vdot(b, b))
        raise RuntimeError(f"the step is known to {reached:.2g} only, not to {tolerance:.2g}")
    return x
