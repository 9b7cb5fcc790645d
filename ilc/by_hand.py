"""Iterative learning on a plant that a person runs: the log in, the next correction out.

```
state = ByHand(law=law, reference=r)       # k = 0: run the task without correction
state = state.record(y_0)                  # state.correction is now u_1
state.save("learning.npz")                 # tomorrow: ByHand.load("learning.npz", law)
```
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, npz

from .laws.first_order import Law
from .measures.norms import inf_norm, two_norm
from .records import as_record


@dataclass(frozen=True, kw_only=True, eq=False)
class ByHand:
    """State between two runs; `record` returns the next state, nothing changes in place.

    The memory of a law is recomputed from the logs, so a saved state holds arrays only.
    """

    law: Law
    reference: Array
    """r, shape (N, n)."""
    outputs: tuple[Array, ...] = ()
    corrections: tuple[Array, ...] = ()
    """u_0 .. u_k, the last is the one to run next; outputs are y_0 .. y_{k-1}, as recorded."""

    def __post_init__(self) -> None:
        reference = as_record(self.reference, "reference")
        object.__setattr__(self, "reference", reference)
        self.law.check(*reference.shape)
        if not self.corrections:
            object.__setattr__(self, "corrections", (np.zeros_like(reference),))
        k, given = len(self.outputs), len(self.corrections)
        if given != k + 1:
            raise ValueError(f"{k} outputs need {k + 1} corrections, got {given}")

    @property
    def k(self) -> int:
        """The iteration to run next."""
        return len(self.outputs)

    @property
    def correction(self) -> Array:
        """u_k, to be run next, shape (N, n)."""
        return self.corrections[-1]

    @property
    def errors(self) -> list[Array]:
        """e_0 .. e_{k-1}."""
        return [self.reference - y for y in self.outputs]

    def record(self, output: ArrayLike) -> "ByHand":
        """The state after the task was run with `correction` and gave `output`, shape (N, n)."""
        y = as_record(output, "output")
        if y.shape != self.reference.shape:
            raise ValueError(f"output must have shape {self.reference.shape}, got {y.shape}")
        outputs = (*self.outputs, y)
        memory, correction = None, self.correction
        for u, y in zip(self.corrections, outputs, strict=True):
            correction, memory = self.law.step(u, self.reference - y, memory)
        return replace(self, outputs=outputs, corrections=(*self.corrections, correction))

    def table(self) -> str:
        """2-norm and largest error of each recorded iteration, one line each."""
        lines = ["k  two-norm  largest"]
        for k, e in enumerate(self.errors):
            lines.append(f"{k}  {np.linalg.norm(two_norm(e)):.4g}  {inf_norm(e).max():.4g}")
        return "\n".join(lines)

    def save(self, file: str | Path) -> None:
        """Write all arrays as .npz."""
        with open(file, "wb") as stream:
            outputs = np.array(self.outputs).reshape(-1, *self.reference.shape)
            corrections = np.array(self.corrections)
            np.savez(stream, reference=self.reference, outputs=outputs, corrections=corrections)

    @classmethod
    def load(cls, file: str | Path, law: Law) -> "ByHand":
        """Continue a saved state with the same law, or with another one from here on."""
        with npz(file) as saved:
            missing = {"reference", "outputs", "corrections"} - set(saved.files)
            if missing:
                raise ValueError(f"{file} lacks {', '.join(sorted(missing))}")
            logs = {name: tuple(saved[name]) for name in ("outputs", "corrections")}
            return cls(law=law, reference=saved["reference"], **logs)
