"""Learning by hand in a folder: `u_k.csv` out, `y_k.csv` in, run by run.

The folder itself is the state. A person runs the task with u_k and puts the log beside it;
corrections are computed again from the logs, so an experiment may be interrupted at any point.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.arrays import Array

from ..laws.first_order import Law
from ..records import records
from .signals import read_signal, write_signal


@dataclass(frozen=True, eq=False)
class ByHand:
    """Runs of an experiment so far."""

    corrections: list[Array]
    """u_0 .. u_k, (N, n) each; the last is the one to run next."""
    errors: list[Array]
    """e_0 .. e_{k-1}."""

    @property
    def k(self) -> int:
        """The iteration to run next."""
        return len(self.errors)


@dataclass(frozen=True, eq=False)
class Folder:
    """Files of an experiment by hand."""

    path: Path
    sample_time: float
    """[s] of reference and corrections."""

    def correction(self, k: int) -> Path:
        return self.path / f"u_{k}.csv"

    def output(self, k: int) -> Path:
        return self.path / f"y_{k}.csv"

    @records("reference")
    def advance(self, law: Law, reference: Array, iterations: int) -> ByHand:
        """Read all logs that are there, k = 0 .. `iterations`, and write the next correction.

        The state's `k` is the run that is waited for; `iterations` + 1 when all are done.
        """
        done, memory = ByHand([np.zeros_like(reference)], []), None
        for k in range(iterations + 1):
            self._offer(k, done.corrections[k])
            if not self.output(k).exists():
                break
            done.errors.append(reference - self._log(k, reference))
            correction, memory = law.step(done.corrections[k], done.errors[k], memory)
            done.corrections.append(correction)
        return done

    def _offer(self, k: int, correction: Array) -> None:
        """Write u_k, or see that the one there is this one."""
        file = self.correction(k)
        if not file.exists():
            waiting = file.with_name(f".{file.name}.part")
            write_signal(waiting, correction, self.sample_time, "u")
            waiting.replace(file)
            return
        if not np.array_equal(read_signal(file).values, correction):
            other = "of another law, reference or log; give the same again, or a new folder"
            raise ValueError(f"{file} is a correction {other}")

    def _log(self, k: int, reference: Array) -> Array:
        log = read_signal(self.output(k))
        values = log.at(len(reference), self.sample_time)
        if values.shape[1] != reference.shape[1]:
            shapes = f"{reference.shape[1]} columns of output, got {values.shape[1]}"
            raise ValueError(f"{self.output(k)} must have {shapes}")
        return values
