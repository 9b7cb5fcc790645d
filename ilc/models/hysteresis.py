"""Stop operators: hysteresis of friction before and after it slips."""

from collections.abc import Sequence

import numpy as np

from armside.arrays import Array

from ..records import records


@records("reference")
def stops(reference: Array, widths: Sequence[float]) -> Array:
    """(N, n, m): stop operators of each column, from -1 to 1: friction before and after it slips.

    A stop of width w follows the reference, divided by w, until it is 1, and waits there until the
    reference turns. Their sums are the hysteresis of Prandtl and Ishlinskii.
    """
    if not all(np.isfinite(w) and w > 0.0 for w in widths):
        raise ValueError(f"widths must be > 0, got {list(widths)}")
    change = np.diff(reference, axis=0, prepend=reference[:1])[:, :, None] / np.array(widths)
    found, state = np.empty_like(change), np.zeros(change.shape[1:])
    for i, step in enumerate(change):
        state = np.clip(state + step, -1.0, 1.0)
        found[i] = state
    return found
