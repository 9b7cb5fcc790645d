"""Test runs in forks of a process that has imported already what most tests import of others.

Nothing of ours is imported before the fork, so each run reads the mutated code.
"""

import contextlib
import math
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Sequence
from importlib import import_module
from typing import IO

TIMED_OUT = -1
"""Exit status of a run that was ended at its limit."""
PATIENCE = 10.0
"""Seconds of the clock for each of processor time: a busy machine ends no run, a run that waits for
ever ends."""
_LIBRARIES = (
    *("numpy", "scipy.signal", "scipy.optimize", "scipy.interpolate", "scipy.sparse.linalg"),
    *("scipy.spatial.transform", "scipy.special", "mujoco.rollout", "numba", "sympy"),
    *("pyarrow.parquet", "matplotlib.figure", "ruckig", "cyclopts", "rich.table", "gymnasium"),
    *("pytest", "_pytest.assertion.rewrite"),
)
_OPTIONS = ("-x", "-q", "-rfE", "-p", "no:cacheprovider", "--no-header", "--color=no")


def warm_up() -> None:
    """Import the libraries of others; one that is missing is left to the tests.

    pytest refuses plugins that are imported before it starts, such as hypothesis.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for name in _LIBRARIES:
        with contextlib.suppress(ImportError):
            import_module(name)


def run_pytest(tests: Sequence[str], limit: float) -> tuple[int, str]:
    """Exit status of pytest, stopped at the first failure, and its output.

    limit: of processor time [s], and in `PATIENCE` times as long.
    """
    with tempfile.TemporaryFile() as output:
        child = os.fork()
        if child == 0:
            resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit), math.ceil(limit) + 1))
            _in_child(tests, output)
        status = _awaited(child, time.monotonic() + PATIENCE * limit)
        output.seek(0)
        return status, output.read().decode(errors="replace")


def _in_child(tests: Sequence[str], output: IO[bytes]) -> None:
    status = 3  # pytest's own for an internal error
    try:
        os.setsid()
        for stream in (1, 2):
            os.dup2(output.fileno(), stream)
        import pytest

        status = int(pytest.main([*_OPTIONS, *tests]))
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _awaited(child: int, deadline: float) -> int:
    """Exit status of a child, which is ended with all of its own at the deadline."""
    while time.monotonic() < deadline:
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            ended = os.waitstatus_to_exitcode(status)
            return TIMED_OUT if ended == -signal.SIGXCPU else ended
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return TIMED_OUT
