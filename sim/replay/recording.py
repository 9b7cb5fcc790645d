"""The file of a replay: everything that is sent to Rerun, whole or not at all."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from ..records.atomic import atomic


@contextmanager
def recording(path: Path, blueprint: rrb.Blueprint) -> Iterator[rr.RecordingStream]:
    """Stream whose content becomes the file when the block ends without an error."""
    stream = rr.RecordingStream("armside", send_properties=False)
    with atomic(path) as partial:
        try:
            # As the default blueprint of the file: one that is sent is not shown by the viewer.
            stream.save(partial, default_blueprint=blueprint)
            yield stream
            stream.flush()
        finally:
            stream.disconnect()
