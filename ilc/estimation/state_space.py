"""Linear, time-invariant models of what is to be estimated, continuous and sampled.

x' = A x + B u + G w        E[w(t) w(s)^T] = W delta(t - s)
y_i = C x(t_i) + v_i        E[v_i v_i^T] = R
"""

from dataclasses import dataclass

import numpy as np

from ..plant import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Process:
    """A sampled process: x_{i+1} = A x_i + w_i, y_i = C x_i + v_i."""

    A: Array
    """(n, n)."""
    Q: Array
    """(n, n), covariance of w_i."""
    C: Array
    """(p, n)."""
    R: Array
    """(p, p), covariance of v_i."""

    def __post_init__(self) -> None:
        n, p = len(self.A), len(self.C)
        for name, shape in (("A", (n, n)), ("Q", (n, n)), ("C", (p, n)), ("R", (p, p))):
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            if value.shape != shape:
                raise ValueError(f"{name} must have shape {shape}, got {value.shape}")
            if not np.isfinite(value).all():
                raise ValueError(f"{name} holds values that are not finite")
            value.setflags(write=False)
            object.__setattr__(self, name, value)


def sampled_noise(A: Array, GWG: Array, step: float) -> tuple[Array, Array]:
    """exp(A h), and the covariance that white noise of intensity GWG leaves after h. Van Loan."""
    from scipy.linalg import expm

    n = len(A)
    block = np.zeros((2 * n, 2 * n))
    block[:n, :n], block[:n, n:], block[n:, n:] = -A, GWG, A.T
    # exp(-A h) of a fast pole overflows digits: split the step until it is short.
    halvings = max(0, int(np.ceil(np.log2(max(1.0, np.abs(A).sum(axis=1).max() * step / 4.0)))))
    exp = expm(block * (step / 2**halvings))
    Ad: Array = np.ascontiguousarray(exp[n:, n:].T)
    Qd: Array = Ad @ exp[:n, n:]
    for _ in range(halvings):
        Qd = Qd + Ad @ Qd @ Ad.T
        Ad = Ad @ Ad
    return Ad, 0.5 * (Qd + Qd.T)


def first_order_hold(A: Array, B: Array, step: float) -> tuple[Array, Array, Array]:
    """Ad, B0, B1 of x_{i+1} = Ad x_i + B0 u_i + B1 u_{i+1}: u is linear between samples."""
    from scipy.linalg import expm

    n, m = B.shape
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m] = A * step, B * step
    block[n : n + m, n + m :] = np.eye(m)
    exp = expm(block)
    B1 = exp[:n, n + m :]
    return exp[:n, :n], exp[:n, n : n + m] - B1, B1
