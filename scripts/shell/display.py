"""Check that a window can be opened."""

import os
import sys

from .errors import InputError


def check_display(instead: str) -> None:
    """Raise InputError where no window can be opened; `instead` says what works without one."""
    if sys.platform == "linux" and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise InputError(f"no display here (neither DISPLAY nor WAYLAND_DISPLAY is set); {instead}")
