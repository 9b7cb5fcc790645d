"""Notes of the instruments of a run."""

from collections.abc import Iterator

from ..notes import Cause, Note
from .laser_tracker import TrackerSamples


def beam(samples: TrackerSamples) -> Iterator[Note]:
    """A note where the beam was lost."""
    if not samples.valid.all():
        lost = "the laser tracker lost its beam: no error of the tool is known"
        yield Note(cause=Cause.BEAM, text=lost)
