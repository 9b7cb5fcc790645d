"""The file of a replay: everything that is sent to Rerun, whole or not at all."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from ..records.atomic import write_bytes


@contextmanager
def recording(path: Path, blueprint: rrb.Blueprint) -> Iterator[rr.RecordingStream]:
    """Stream whose content becomes the file when the block ends without an error.

    Rerun itself does not notice a full disk: what is sent is collected, and written by us.
    """
    stream = rr.RecordingStream("armside", send_properties=False)
    collected = stream.memory_recording()
    try:
        stream.send_blueprint(blueprint, make_active=False)
        yield stream
        content = collected.drain_as_bytes()
    finally:
        stream.disconnect()
    write_bytes(path, content)
