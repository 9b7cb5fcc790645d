"""Notes of recorded data: limits that were touched, and a beam that was lost."""

from collections.abc import Iterator

import pyarrow as pa

from ..cut.notes import motion_notes
from ..cut.tool_motion import ToolMotion
from ..instruments.laser_tracker import beam
from ..notes import Cause, Note, together
from ..records.signals import Signals
from ..records.tables import TRUTH_VALUE
from ..robot.recording import saturation


def notes_of_signals(signals: Signals) -> list[Note]:
    """Notes of a stored run: of its programmed path, and of each iteration."""
    return together(_of_signals(signals))


def _of_signals(signals: Signals) -> Iterator[Note]:
    if isinstance(signals.path, ToolMotion):
        yield from motion_notes(signals.path)
    for run in signals.runs:
        yield from (note.at(run.k) for note in saturation(run.recording))
        if run.tracker is not None:
            yield from (note.at(run.k) for note in beam(run.tracker))


def notes_of_table(table: pa.Table) -> list[Note]:
    """Notes of any other table: samples that its column `tracker_valid` calls lost."""
    if TRUTH_VALUE not in table.column_names:
        return []
    lost = table[TRUTH_VALUE].cast(pa.bool_()).to_pylist().count(False)
    if not lost:
        return []
    text = f"the laser tracker lost its beam in {lost} samples, which are left out"
    return [Note(cause=Cause.BEAM, text=text)]
