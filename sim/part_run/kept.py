"""What is kept of a run over a part: its signals at the log rate."""

from dataclasses import replace

from ..instruments.laser_tracker import TrackerSamples
from ..instruments.noise import rate_of, stride
from ..records.signals import RecordedRun
from ..robot.virtual_robot import LOG_PERIOD
from .learning import PartIteration


def kept_run(iteration: PartIteration) -> RecordedRun:
    """Log, ground truth and tracker of an iteration, all at the log rate."""
    log, seen = iteration.run.recording, iteration.run.tracker
    truth = log.truth.every(_stride(rate_of(log.truth.time)))
    every = _stride(rate_of(seen.time))
    tracker = TrackerSamples(
        time=seen.time[::every], position=seen.position[::every], valid=seen.valid[::every]
    )
    return RecordedRun(k=iteration.k, recording=replace(log, truth=truth), tracker=tracker)


def _stride(rate: float) -> int:
    return stride(rate, 1.0 / LOG_PERIOD)
