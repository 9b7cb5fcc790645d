"""The array type of all packages, and checks of arguments and of records of samples."""

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
"""float64; docstrings give shape and unit."""


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Contiguous view, or copy, of an array that cannot be written to.

    For arguments of compiled functions: numba compiles one for arrays that can be written to and
    another, with the same result, for those that cannot.
    """
    view = np.ascontiguousarray(array).view()
    view.setflags(write=False)
    return view


def freeze_rows(record: Any, *names: str) -> None:
    """Make arrays of a record read-only; ValueError unless each has a row for each `time`."""
    for name in names:
        value = getattr(record, name)
        if len(value) != len(record.time):
            raise ValueError(f"{name} must have {len(record.time)} rows, got {len(value)}")
        value.setflags(write=False)


def real_array(name: str, value: ArrayLike, *shape: int) -> Array:
    """A float64 array of an array-like, whose last axes have the lengths `shape`.

    Raises:
        ValueError: complex numbers, masked entries, text, or another shape.
    """
    given = value if isinstance(value, np.ndarray) else np.asarray(value)
    if isinstance(value, list | tuple) and any(isinstance(one, bool) for one in value):
        raise ValueError(f"{name} must be real numbers, got a truth value")
    if given.dtype.kind not in "fiu" or isinstance(given, np.ma.MaskedArray):
        kind = "a masked array" if isinstance(given, np.ma.MaskedArray) else str(given.dtype)
        raise ValueError(f"{name} must be real numbers, got {kind}")
    if shape and given.shape[-len(shape) :] != shape:
        needed = ", ".join(["...", *map(str, shape)])
        raise ValueError(f"{name} must have shape ({needed}), got {given.shape}")
    return np.asarray(given, dtype=np.float64)


def shown(value: Any) -> str:
    """A value on one short line, an array of several axes by its shape."""
    if np.ndim(value) > 1:
        return f"an array of shape {np.shape(value)}"
    text = " ".join(str(value).split())
    return text if len(text) <= 60 else f"{text[:60]}..."


def check_numbers(record: Any, *names: str, several: bool = False, nan: bool = False) -> None:
    """Refuse fields of a record that are not a number each, or with `several` one or more, (m,).

    Truth values and text are no numbers, nor is NaN; with `nan` it is left to the record, whose
    message has a bound. Infinity is a number. None is left to the record.

    Raises ValueError with name and value.
    """
    for name in names:
        value = getattr(record, name)
        if value is None:
            continue
        array = np.asarray(value) if np.ndim(value) <= 1 else np.empty((0, 0))
        numbers = array.dtype.kind in "iuf" and array.size and (nan or not np.isnan(array).any())
        if not numbers or array.ndim > several:
            kind = "numbers" if several else "one number"
            raise ValueError(f"{name} must be {kind}, got {shown(value)}")


def finite_array(name: str, value: ArrayLike, *shape: int) -> Array:
    """Like `real_array`, without NaN and infinities."""
    array = real_array(name, value, *shape)
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got NaN or infinity")
    return array


SLOWEST, FASTEST = 0.5, 1e-5
"""[s] Median step of a robot's recording, at most and at least. ESTIMATE: instruments and
controllers sample at 5 Hz to 10 kHz, so that times in milliseconds or minutes lie outside."""
LONGEST_GAP = 1.0
"""[s] Without samples, which a spline may bridge. ESTIMATE: robots of this size move at 0.1 to
1 Hz; the recordings of an AUBO i5 have gaps up to 0.12 s."""


def check_rising(source: Any, time: Array, rows: Any = None, *, repeats: bool = False) -> None:
    """Refuse times (N,) that are not finite, or do not increase.

    Args:
        source: name of the recording, for the message.
        rows: (N,) numbers of their rows from 0, of a part of a table.
        repeats: stamps may repeat, as rounded ones do.

    Raises:
        ValueError: names row and value.
    """
    bad = ~np.isfinite(time)
    step = np.diff(np.where(bad, 0.0, time))
    back = np.r_[False, step < 0.0 if repeats else step <= 0.0]
    if not (bad | back).any():
        return
    at = int(np.argmax(bad)) if bad.any() else int(np.argmax(back))
    row = 1 + (at if rows is None else int(rows[at]))
    if bad.any():
        raise ValueError(f"{source}: column time, row {row}: must be a time [s], got {time[at]}")
    text = f"time must increase, got {time[at]:.9g} s after {time[at - 1]:.9g} s"
    fault = "runs backwards" if step[at - 1] < 0.0 else "stands still"
    raise ValueError(f"{source}: column time, row {row}: {text}: the clock {fault}")


def check_recorded_time(
    source: Any, time: Array, rows: Any = None, *, gap: float = LONGEST_GAP, repeats: bool = False
) -> None:
    """Like `check_rising`, for instants of a robot or of an instrument beside it [s].

    Raises ValueError for a rate that nothing samples at, and for a gap longer than `gap` [s].
    """
    check_rising(source, time, rows, repeats=repeats)
    if len(time) < 2:
        return
    steps = np.diff(time)
    if not FASTEST <= (median := float(np.median(steps))) <= SLOWEST and median > 0.0:
        unit = "milliseconds" if median > SLOWEST else "minutes or hours"
        bound = f"{FASTEST:g} to {SLOWEST:g} s can be right"
        text = f"one sample each {median:.4g} s; {bound}: are they in {unit}?"
        raise ValueError(f"{source}: column time, row 2: {text}")
    if (longest := float(steps.max())) > gap:
        at = int(steps.argmax())
        row = 1 + (at if rows is None else int(rows[at]))
        text = f"no samples for {longest:.3g} s after {time[at]:.4g} s; at most {gap:g} s"
        raise ValueError(f"{source}: column time, row {row}: {text}; cut the recording there")


LARGEST_UNPACKED = 1_000_000_000
"""[bytes], of all arrays of an .npz file: they are held in memory."""


@contextmanager
def npz(file: Any) -> Iterator[Any]:
    """Arrays of an .npz file, without pickled objects. file: path or open file.

    Raises ValueError for another kind of file, and for arrays that unpack to more than
    `LARGEST_UNPACKED`, before they do.
    """
    try:
        with zipfile.ZipFile(file) as packed:
            size = sum(member.file_size for member in packed.infolist())
    except zipfile.BadZipFile as error:
        raise ValueError(f"{file} is no .npz file: {error}") from error
    if size > LARGEST_UNPACKED:
        bound = f"{size / 1e6:.4g} MB; at most {LARGEST_UNPACKED / 1e6:.4g} MB are read"
        raise ValueError(f"{file} unpacks to {bound}")
    if hasattr(file, "seek"):
        file.seek(0)
    with np.load(file, allow_pickle=False) as arrays:
        yield arrays


def check_out(out: Any, shape: tuple[int, ...]) -> None:
    """Refuse an `out=` that is no float64 array of a shape."""
    if not isinstance(out, np.ndarray):
        raise ValueError(f"out must be float64 of shape {shape}, got {type(out).__name__}")
    if out.shape != shape or out.dtype != np.float64:
        raise ValueError(f"out must be float64 of shape {shape}, got {out.dtype} of {out.shape}")
