"""One configuration of a sweep: a job whose result is a row of the dataset."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from armside.sim.records.summary import plain

from ..cutting.learning import run
from ..cutting.options import LaserCfg
from ..shell.errors import one_line
from .blocks import FAILED, Blocks, Row
from .dataset import measures
from .queue import Engine, Queue
from .resolved import key_of, resolved
from .store import code_fingerprint
from .workers import WorkerDied


@dataclass(frozen=True)
class Point:
    """Options of `armside laser` and a seed."""

    key: str
    """Hash of the whole configuration: resolved options, content of files, and seed."""
    options: Mapping[str, Any]
    """Options, typed; those left out have their defaults."""
    seed: int

    @property
    def cost(self) -> float:
        """Equal: a grid is run in its order."""
        return 1.0

    def run(self) -> Row:
        """The row of its run. An exception becomes the row of a failure."""
        try:
            outcome = run(LaserCfg(**self.options), self.seed)
            if key_of(self.options, self.seed) != self.key:
                error = "a file of its options is not what it was when the sweep began"
                return self._row(status=FAILED, error=error)
            return self._row(status=outcome["status"], **measures(outcome))
        except Exception as error:
            return self.failed(error)

    def failed(self, error: Exception) -> Row:
        """Its row without a result."""
        kind = "" if isinstance(error, WorkerDied) else f"{type(error).__name__}: "
        return self._row(status=FAILED, error=kind + one_line(error))

    def _row(self, **columns: Any) -> Row:
        try:
            options = resolved(LaserCfg(**self.options))
        except (ValueError, OSError):
            options = plain(self.options)
            if options.get("individual") is not None:
                options["individual"] = str(options["individual"])
        made_with = {"version": version("armside"), "code": code_fingerprint()[:12]}
        return {"key": self.key, "seed": self.seed, **options, **made_with, **columns}


def run_grid(
    points: Iterable[Point],
    rows: Blocks,
    engine: Engine,
    step: Callable[[], None] = lambda: None,
    *,
    retry_failed: bool = False,
    waiting: Callable[[int], None] = lambda n: None,
) -> Counter[str]:
    """Bring a dataset up to all points of a grid; `step` is called for each that has a row.

    The rest, the returned counts and the errors are those of `Queue.complete`.
    """
    jobs = {point.key: point for point in points}

    def row(key: str, outcome: Row | Exception) -> Row:
        return jobs[key].failed(outcome) if isinstance(outcome, Exception) else outcome

    how: dict[str, Any] = {"retry_failed": retry_failed, "waiting": waiting}
    queue = Queue(blocks=rows, engine=engine, row=row, done=lambda _: step(), **how)
    return queue.complete(jobs)
