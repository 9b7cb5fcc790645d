"""The file of a replay: everything that is sent to Rerun, whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import copyfileobj
from threading import Thread

import rerun as rr
import rerun.blueprint as rrb

from ..records.atomic import atomic


@contextmanager
def recording(path: Path, blueprint: rrb.Blueprint) -> Iterator[rr.RecordingStream]:
    """Stream whose content becomes the file when the block ends without an error.

    Raises OSError, such as on a full disk.
    """
    stream = rr.RecordingStream("armside", send_properties=False)
    with atomic(path) as partial, _copied_to(partial) as pipe:
        try:
            # As the default blueprint of the file: one that is sent is not shown by the viewer.
            stream.save(pipe, default_blueprint=blueprint)
            yield stream
            stream.flush()
        finally:
            stream.disconnect()


@contextmanager
def _copied_to(file: Path) -> Iterator[str]:
    """Name of a pipe whose content is written to a file.

    Rerun's own writer, on a full disk, waits for ever or ends the process without an error.
    """
    source, sink = os.pipe()
    failures: list[OSError] = []
    copying = Thread(target=_copy, args=(source, file, failures))
    copying.start()
    try:
        yield f"/dev/fd/{sink}"
    finally:
        os.close(sink)
        copying.join()
    for failure in failures:
        raise failure


def _copy(source: int, file: Path, failures: list[OSError]) -> None:
    with open(source, "rb") as content:
        try:
            with file.open("wb") as out:
                copyfileobj(content, out)
        except OSError as error:
            failures.append(error)
            while content.read(1 << 20):  # or whoever writes into the pipe would wait
                pass
