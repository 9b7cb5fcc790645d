"""A correction carried over to the same path at another speed."""

import numpy as np

from armside.arrays import Array

from ..records import as_real, records


@records("correction")
def along_path(correction: Array, place: Array, wanted: Array) -> Array:
    """The correction (N, n) learned at `place` (N,), at the places `wanted` (M,): shape (M, n).

    Linear in between; before and beyond the path that was learned it keeps its end values. This
    takes the correction for a function of the place alone, so delays of the servo are not scaled.
    place: [m], not decreasing.

    Raises ValueError for places that are no such numbers.
    """
    place, wanted = as_real(place, "place"), as_real(wanted, "wanted")
    if place.shape != (len(correction),) or not (np.diff(place) >= 0.0).all():
        raise ValueError(f"place must be {len(correction)} numbers that do not decrease")
    if not np.isfinite(wanted).all():
        raise ValueError("wanted must be finite")
    first = np.flatnonzero(place <= place[0])[-1]  # the end of the rest before
    moving = np.concatenate(([True], np.diff(place[first:]) > 0.0))
    known, values = place[first:][moving], correction[first:][moving]
    return np.stack([np.interp(wanted, known, column) for column in values.T], axis=1)
