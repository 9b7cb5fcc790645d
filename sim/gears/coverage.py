"""What recordings show of each joint: fraction of usable samples, smallest error that is found.

A sample is usable for a joint if the sensor saw it, without a hole as long as half a period of the
band's end, and if the joint moves at a rate at which an order of the scan falls into the band.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..recordings.alignment.encoder_motion import RATE
from ..recordings.recording import SHORTEST, Stream
from .aligned import Aligned
from .learning import CHANCE
from .scan import SMALLEST

if TYPE_CHECKING:
    from .analysis import GearAnalysis

WHOLE = 0.9
"""Fraction of the motion that a sensor saw, below which it is said."""


class Coverage(NamedTuple):
    """What the recordings show of one joint."""

    usable: float
    """Fraction of the samples of the motion."""
    seconds: float
    """[s] The same as a time."""
    smallest: float
    """[rad] Amplitude from which on an order stands out from chance; median over the orders."""


def coverage(done: "GearAnalysis") -> tuple[Coverage, ...]:
    """Coverage of each joint by all recordings."""
    usable = np.concatenate([_usable(done, one) for one in done.aligned])
    smallest = [
        np.median(np.sqrt(CHANCE * typical / np.maximum(unit, np.finfo(np.float32).tiny)))
        for typical, unit in zip(done.scan.typical, done.scan.unit, strict=True)
    ]
    return tuple(
        Coverage(float(own.mean()), float(own.sum() / RATE), float(amplitude))
        for own, amplitude in zip(usable.T, smallest, strict=True)
    )


def coverage_notes(done: "GearAnalysis") -> tuple[str, ...]:
    """A line for each recording that a sensor saw a part of, and joint of which nothing was found.

    Of an error that is missed the line states the median over the orders.
    """
    found = set() if done.found is None else {term.joint for term in done.found.terms}
    notes = [note for one in done.aligned if (note := _seen_note(done, one))]
    for joint, own in enumerate(coverage(done), 1):
        if joint not in found:
            notes.append(f"joint {joint}: {_missed(own)}")
    return tuple(notes)


def _missed(own: Coverage) -> str:
    usable = f"{100 * own.usable:.0f} % of samples usable"
    if own.seconds < SHORTEST:
        return f"cannot be judged: {usable}, {own.seconds:.2g} s of {SHORTEST:g} needed"
    return f"no order found: {usable}, errors below {1e6 * own.smallest:.0f} µrad missed"


def _seen_note(done: "GearAnalysis", one: Aligned) -> str:
    fraction = float(_seen(done, one).mean())
    if fraction >= WHOLE:
        return ""
    seen = f"{100 * fraction:.0f} % of the motion"
    return f"{one.name}: encoders and {done.sensor} saw {seen} without holes"


def _usable(done: "GearAnalysis", one: Aligned) -> NDArray[np.bool_]:
    """(M, n), samples of a recording's motion that are usable for each joint."""
    low, high = 2.0 * np.pi * np.array(done.cfg.band)
    rate = np.abs(one.motion.rate)
    shown = (rate * done.cfg.largest_order >= low) & (rate * SMALLEST <= high)
    return shown & _seen(done, one)[:, None]


def _seen(done: "GearAnalysis", one: Aligned) -> NDArray[np.bool_]:
    """(M,), samples of a recording's motion that encoders and sensor saw."""
    hole, motion = 0.5 / done.cfg.band[1], one.motion
    by_encoders = _without_holes(one.recording.encoders, motion.time, hole)
    stream: Stream | None = getattr(one.recording, done.sensor)
    assert stream is not None
    return by_encoders & _without_holes(stream, one.clock(done.sensor), hole)


def _without_holes(stream: Stream, time: NDArray[np.float64], hole: float) -> NDArray[np.bool_]:
    """True where a time lies between two samples that are at most `hole` apart [s]."""
    place = np.searchsorted(stream.time, time)
    inside = (place > 0) & (place < len(stream.time))
    place = np.clip(place, 1, len(stream.time) - 1)
    return inside & (stream.time[place] - stream.time[place - 1] <= hole)
