"""Points of a sweep that do not run an experiment, for worker processes to import."""

import math
import os
import signal
from dataclasses import dataclass
from typing import Any

from armside.scripts.jobs.grid import Point


def root_or_end(value: float) -> float:
    """Square root; the process ends where there is none."""
    return math.sqrt(value) if value >= 0.0 else os._exit(1)


@dataclass(frozen=True)
class Quick:
    """Has a row without an experiment."""

    point: Point

    @property
    def key(self) -> str:
        return self.point.key

    def run(self) -> dict[str, Any]:
        return self.failed(RuntimeError()) | {"status": "done", "error": None}

    def failed(self, error: Exception) -> dict[str, Any]:
        return self.point.failed(error)


class DiesWithSeed1(Quick):
    """Takes its process along where the seed is 1."""

    def run(self) -> dict[str, Any]:
        if self.point.seed == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().run()
