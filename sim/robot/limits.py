"""Limits that a run touched, as notes."""

from collections.abc import Iterable

from ..notes import Cause, Note
from .recording import Recording

_MEANING = {
    "torque": "drives saturate: torque limit of axis {axes}",
    "speed": "speed limit of axis {axes} is reached",
    "joint": "hard stop of axis {axes} is reached",
}


def saturation(recording: Recording) -> Iterable[Note]:
    """A note for each kind of limit, with its axes."""
    for limit, meaning in _MEANING.items():
        axes = [str(axis) for name, axis, _ in recording.limits_hit if name == limit]
        if axes:
            yield Note(cause=Cause.SATURATION, text=meaning.format(axes=", ".join(axes)))
