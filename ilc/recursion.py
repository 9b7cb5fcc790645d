"""One recursion a(q) y = b(q) x along records, from zero state."""

import numpy as np

from .plant import Array


def recursion(b: Array, a: Array, signal: Array) -> Array:
    """Filter b/a along the first axis of a signal (N, n); powers of q^-1, a[0] = 1.

    The recursion is a banded triangular system of equations, which LAPACK solves for all columns
    at once in O(N). scipy.signal has the same but takes most of a second to import.
    """
    from scipy.linalg import lapack  # here: 0.1 s that importing a law should not cost

    n_samples = len(signal)
    moving_average = b[0] * signal
    for lag in range(1, min(len(b), n_samples)):
        moving_average[lag:] += b[lag] * signal[:-lag]
    if len(a) == 1:
        return moving_average
    band = np.repeat(a[:, None], n_samples, axis=1)
    filtered, _ = lapack.dtbtrs(band, moving_average, uplo="L")  # type: ignore[attr-defined]
    return filtered
