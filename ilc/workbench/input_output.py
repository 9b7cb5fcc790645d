"""Records of inputs and outputs, from a CSV or MAT file, or from an experiment on a plant."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..identification.frequency_response import lines_between, orthogonal_multisines
from ..records import as_record
from .signals import read_signal
from .task import Task

_LARGEST = 1e100  # range of a column; its inverse is the smallest: squares stay finite
_EXCITED = 1e-2  # least power of a line relative to the greatest
_IRREGULAR = 1e-3  # largest deviation of a step of time from the sample time, relative


@dataclass(frozen=True, kw_only=True, eq=False)
class InputOutput:
    """u (N, m) and y (N, p), sampled at the same instants."""

    u: Array
    y: Array
    sample_time: float
    """[s]."""
    period: int = 0
    """[samples] of a periodic input; 0: none is stated."""
    lines: tuple[int, ...] = ()
    """Harmonics of the period that are excited; empty: unknown."""

    def __post_init__(self) -> None:
        for name in "uy":
            object.__setattr__(self, name, as_record(getattr(self, name), name))
            with np.errstate(over="ignore"):
                ranges = np.ptp(getattr(self, name), axis=0)
            if not ranges.all():
                raise ValueError(f"a column of {name} does not vary")
            if not 1.0 / _LARGEST <= ranges.min() <= ranges.max() <= _LARGEST:
                allowed = f"{1.0 / _LARGEST:g} to {_LARGEST:g}"
                given = f"{ranges.min():g} to {ranges.max():g}"
                raise ValueError(f"columns of {name} must vary by {allowed}, got {given}")
        if len(self.u) != len(self.y):
            raise ValueError(f"u and y must have one length, got {len(self.u)} and {len(self.y)}")

    @property
    def centred(self) -> "InputOutput":
        """Deviations from the means: from the operating point."""
        u, y = self.u - self.u.mean(axis=0), self.y - self.y.mean(axis=0)
        return replace(self, u=u, y=y)

    def with_period(self, period: int) -> "InputOutput":
        """The same record, its input known to repeat; lines are those that hold power."""
        if self.u.shape[1] > 1:
            raise ValueError(f"a period is for one input, the record has {self.u.shape[1]}")
        if (n := len(self.u) // period) < 3:
            raise ValueError(f"three periods are needed, the record holds {n} of {period} samples")
        one = self.u[: n * period, 0].reshape(n, period).mean(axis=0)
        power = np.square(np.abs(np.fft.rfft(one)))[1 : (period + 1) // 2]
        lines = 1 + np.flatnonzero(power >= _EXCITED * power.max())
        return replace(self, period=period, lines=tuple(lines.tolist()))


def read_input_output(
    file: Path, n_inputs: int = 1, sample_time: float | None = None
) -> InputOutput:
    """From a CSV file with columns time (perhaps), inputs, outputs, or MAT variables u and y.

    sample_time: [s], where the file has neither time nor sample_time. Raises ValueError, with the
    file's name.
    """
    try:
        return _read(file, n_inputs, sample_time)
    except ValueError as error:
        raise ValueError(f"{file}: {str(error).removeprefix(f'{file}: ')}") from error


def _read(file: Path, n_inputs: int, sample_time: float | None) -> InputOutput:
    if file.suffix.lower() == ".mat":
        return _from_mat(file, sample_time)
    signal = read_signal(file)
    n = signal.values.shape[1]
    if n <= n_inputs:
        needed = f"{n_inputs} columns of inputs and at least one of outputs"
        raise ValueError(f"{file} must have {needed}, got {n} in all")
    if signal.time is not None and len(signal.time) > 1:
        steps = np.diff(signal.time)
        if np.abs(steps - np.median(steps)).max() > _IRREGULAR * np.median(steps):
            raise ValueError(f"{file}: time must have equal steps, got {steps.min():g} s to "
                             f"{steps.max():g} s")  # fmt: skip
    step = signal.sample_time  # rounded: differences of printed times are not exact
    stated = None if step is None else float(f"{step:.9g}")
    given = _sample_time(file, stated, sample_time)
    return InputOutput(
        u=signal.values[:, :n_inputs], y=signal.values[:, n_inputs:], sample_time=given
    )


def _from_mat(file: Path, sample_time: float | None) -> InputOutput:
    from scipy.io import loadmat

    try:
        found: dict[str, Any] = loadmat(file)
    except Exception as error:  # scipy raises many kinds for a damaged file
        raise ValueError(f"{file} is not a readable MAT file: {error}") from error
    if missing := [name for name in "uy" if name not in found]:
        raise ValueError(f"{file} lacks {' and '.join(missing)}: it needs u and y, time down")
    time = np.ravel(found["sample_time"]) if "sample_time" in found else np.zeros(0)
    stated = float(time[0]) if time.size == 1 and time.dtype.kind in "iuf" else None
    columns = (np.asarray(found[name]) for name in "uy")
    u, y = (M.T if M.ndim == 2 and len(M) == 1 else M for M in columns)
    return InputOutput(u=u, y=y, sample_time=_sample_time(file, stated, sample_time))


def _sample_time(file: Path, stated: float | None, given: float | None) -> float:
    if stated is not None and given is not None and not np.isclose(stated, given, rtol=1e-3):
        raise ValueError(f"{file} has a sample time of {stated:g} s, got {given:g} s")
    found = given if given is not None else stated
    if found is None or not (np.isfinite(found) and found > 0.0):
        raise ValueError(f"{file} states no sample time: give --sample-time")
    return found


def excited(
    task: Task, column: int, rms: float, highest: float, n_periods: int, rng: np.random.Generator
) -> InputOutput:
    """Deviation that a multisine in one correction causes: one run with it, one without.

    It has equal power at all lines up to `highest` [Hz]. Samples beyond the last whole period are
    omitted. Raises ValueError for a record that is too short.
    """
    n_samples, n_columns = task.reference.shape
    if not 1 <= column <= n_columns:
        raise ValueError(f"column must be 1 to {n_columns}, got {column}")
    if (period := n_samples // n_periods) < 20:
        raise ValueError(f"{n_samples} samples hold {n_periods} periods of {period}, not of 20")
    lines = lines_between(1.0 / (period * task.sample_time), highest, period,
                          task.sample_time)  # fmt: skip
    one = orthogonal_multisines(period, lines, 1, rng, rms=rms)[0, :, 0]
    u = np.zeros((n_samples, n_columns))
    u[: period * n_periods, column - 1] = np.tile(one, n_periods)
    plant = task.start(0)
    without, with_it = (task.output_of(plant.run(c)) for c in (np.zeros_like(u), u))
    whole = slice(0, period * n_periods)
    moved = (np.asarray(with_it) - np.asarray(without))[whole, [column - 1]]
    return InputOutput(
        u=u[whole, [column - 1]], y=moved, sample_time=task.sample_time,
        period=period, lines=tuple(lines),
    )  # fmt: skip
