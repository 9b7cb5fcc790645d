"""A line on stderr for what only the first use of a robot waits for."""

import logging
import sys

_LOG = logging.getLogger("armside.kinematics.cache")


class _Stderr(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        print(f"armside: {record.getMessage()}", file=sys.stderr, flush=True)


def show_compilation() -> None:
    """Print a line for each function of a robot that is compiled, unless logging is set up."""
    if not _LOG.hasHandlers():
        _LOG.addHandler(_Stderr())
        _LOG.setLevel(logging.INFO)
