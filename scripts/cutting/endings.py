"""Endings of a learning run that are failures."""

from collections.abc import Mapping
from typing import Any

from ..shell.errors import RunFailed

_ENDS = {
    "diverged": "learning diverged at iteration {k}",
    "worse": "learning made the tool worse than before",
}


def fail_unless_done(outcome: Mapping[str, Any]) -> None:
    """Raise RunFailed for a summary whose status is a failure; its files are written by then."""
    if outcome["status"] in _ENDS:
        raise RunFailed(_ENDS[outcome["status"]].format(k=outcome["iterations"][-1]["k"]))
