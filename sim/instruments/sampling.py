"""Sampling of a fine record by a slower instrument."""

from armside.arrays import Array


def stride(record_rate: float, rate: float) -> int:
    """Rows of a record per sample of an instrument; ValueError unless its rate [Hz] divides."""
    if not (rate > 0.0 and record_rate > 0.0):
        raise ValueError(f"rates must be > 0 Hz, got {rate} and {record_rate}")
    every = round(record_rate / rate)
    if every < 1 or abs(every * rate - record_rate) > 1e-6 * record_rate:
        raise ValueError(f"rate {rate:g} Hz must divide the {record_rate:g} Hz of the record")
    return every


def rate_of(time: Array) -> float:
    """Rate [Hz] of a uniform time axis, which needs two samples at least."""
    if len(time) < 2:
        raise ValueError(f"a rate needs at least 2 samples, got {len(time)}")
    return float((len(time) - 1) / (time[-1] - time[0]))
