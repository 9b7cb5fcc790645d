"""Notes of an IMU experiment: what limits made of its motion and of its samples."""

from collections.abc import Iterator, Sequence

from ..motion.planner import slower_moves
from ..notes import Cause, Note, together
from ..robot.limits import saturation
from .experiment import ImuResult


def notes(runs: Sequence[ImuResult]) -> list[Note]:
    """Notes of all programs, each once with the runs that it concerns."""
    return together(note.at(k) for k, one in enumerate(runs) for note in _of_run(one))


def _of_run(one: ImuResult) -> Iterator[Note]:
    yield from slower_moves(one.planned.motion)
    yield from saturation(one.run.recording)
    samples = one.run.samples
    for name, clipped in (
        ("accelerometer", samples.acceleration_clipped),
        ("gyro", samples.angular_velocity_clipped),
    ):
        if clipped.any():
            fraction = 100.0 * float(clipped.any(axis=1).mean())
            text = f"{fraction:.2g} % of the {name}'s samples are clipped at its range"
            yield Note(cause=Cause.IMU, text=text)
