"""A command that ends as it is told to, to test the command line with."""

import os
import shutil
import signal
import time
from dataclasses import dataclass
from enum import Enum

from armside.scripts import cli
from armside.scripts.shell.console import Report
from armside.scripts.shell.errors import RunFailed, checking_input
from armside.scripts.shell.options import Common, options
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

load_ours = cli.load


def load(name: str):
    """`cli.load` with the probe among the commands."""
    return probe if name == "probe" else load_ours(name)


class End(Enum):
    DONE = "done"
    DIVERGED = "diverged"
    BUG = "bug"
    VALUE_ERROR = "value-error"
    NO_FILE = "no-file"
    INTERRUPTED = "interrupted"
    TERMINATED = "terminated"
    HUNG_UP = "hung-up"
    HUNG_UP_ONLY = "hung-up-only"
    LATE = "late"
    REMOVED = "removed"
    KILLED = "killed"
    SLOW = "slow"


SIGNALS = {
    End.INTERRUPTED: signal.SIGINT,
    End.TERMINATED: signal.SIGTERM,
    End.HUNG_UP: signal.SIGHUP,
}


@options
@dataclass(frozen=True, kw_only=True)
class ProbeCfg:
    """How the probe goes."""

    end: End = End.DONE
    """How it ends."""
    radius: float = 5.0
    """Radius [mm]."""
    iterations: int = 5
    """Number of updates."""
    size: int = 0
    """Bytes to write beside the summary."""

    def __post_init__(self) -> None:
        if not self.radius > 0.0:
            raise ValueError(f"radius must be > 0 mm, got {self.radius}")


def probe(*, cfg: ProbeCfg = ProbeCfg(), common: Common = Common()) -> None:
    """End as told to.

    Raises RunFailed when told to diverge.

    Writes summary.json.
    """
    with checking_input():
        if cfg.end is End.NO_FILE:
            open("no-such-model.xml").close()
    report = Report(common)
    with RunFolder("probe", seed=common.seed, out=common.out) as folder:
        (folder / "summary.json").write_text("{}")
        (folder / "signals.parquet").write_bytes(bytes(cfg.size))
        with report.progress("probing", total=1) as step:
            step()
        match cfg.end:
            case End.BUG:
                raise KeyError("elbow")
            case End.VALUE_ERROR:
                raise ValueError("matrix is singular")
            case End.INTERRUPTED | End.TERMINATED | End.HUNG_UP:
                os.kill(os.getpid(), SIGNALS[cfg.end])
                time.sleep(60)
            case End.HUNG_UP_ONLY:
                os.kill(os.getpid(), signal.SIGHUP)
            case End.REMOVED:
                shutil.rmtree(folder._staging)
            case End.KILLED:
                os.kill(os.getpid(), signal.SIGKILL)
        outcome = summary("probe", cfg, common, value=0.1, missing=float("nan"))
        (folder / "summary.json").write_text(dumps(outcome))
    if cfg.end is End.LATE:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(60)
    report.table("Probe", ["k", "error"], [[0, 0.125], [1, 0.0625]])
    report.summary(outcome)
    if cfg.end is End.DIVERGED:
        raise RunFailed("diverged at k = 3")
