"""Runs on disk: signals, tables, summaries, and the folders that hold them.

    run = read_run("runs/first")
    run.summary, run.signals.runs[0].recording.error, run.path.position

SI units, radians, time-major arrays; quaternions w first.
"""

from .stored_run import StoredRun as StoredRun
from .stored_run import read_run as read_run
