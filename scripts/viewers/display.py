"""Windows on this machine: whether one can be opened, and Rerun's native viewer in one."""

import os
import subprocess
import sys
from pathlib import Path

from ..shell.errors import InputError, RunFailed


def check_display(instead: str) -> None:
    """Raise InputError where no window can be opened; `instead` names a way without one."""
    if sys.platform == "linux" and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise InputError(f"no display here (neither DISPLAY nor WAYLAND_DISPLAY is set); {instead}")


def show(file: Path, telemetry: bool) -> None:
    """Show a replay in Rerun's native viewer until its window is closed.

    Raises RunFailed where the viewer fails.
    """
    from .web_viewer import LOOPBACK, private_environment, rerun_program

    command = [rerun_program(), str(file), "--bind", LOOPBACK, "--port", "auto"]
    with private_environment(telemetry) as env:
        try:
            status = subprocess.run(command, env=env, check=False).returncode
        except KeyboardInterrupt:
            return
    if status:
        raise RunFailed(f"the viewer ended with status {status}; --web shows it in a browser")
