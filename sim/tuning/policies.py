"""Policies that map an observation of the env to an action, with NumPy alone."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.arrays import Array, npz


@dataclass(frozen=True, kw_only=True)
class Network:
    """x -> W_n tanh(... tanh(W_1 x + b_1) ...) + b_n, clipped to [-1, 1]."""

    weights: tuple[Array, ...]
    """Each (outputs, inputs); the biases each (outputs,)."""
    biases: tuple[Array, ...]

    def __post_init__(self) -> None:
        if not self.weights or len(self.weights) != len(self.biases):
            raise ValueError(
                f"a network needs as many weights as biases, got {len(self.weights)} and "
                f"{len(self.biases)}"
            )

    def __call__(self, observed: np.ndarray) -> np.ndarray:
        """The action, float32, for an observation (n,) or one in each row."""
        x = np.asarray(observed, dtype=np.float64)
        for W, b in zip(self.weights[:-1], self.biases[:-1], strict=True):
            x = np.tanh(x @ W.T + b)
        return np.clip(x @ self.weights[-1].T + self.biases[-1], -1.0, 1.0).astype(np.float32)

    def save(self, file: Path) -> None:
        """Write as .npz."""
        layers = enumerate(zip(self.weights, self.biases, strict=True))
        arrays = {f"{s}{i}": a for i, layer in layers for s, a in zip("Wb", layer, strict=True)}
        np.savez(file, **arrays)  # type: ignore[arg-type]

    @classmethod
    def load(cls, file: Path) -> "Network":
        """Read a file that `save` has written. Raises ValueError for another kind of file."""
        with npz(file) as arrays:
            n = len(arrays.files) // 2
            if sorted(arrays.files) != sorted(f"{s}{i}" for s in "Wb" for i in range(n)):
                raise ValueError(f"{file} is not a policy: it holds {', '.join(arrays.files)}")
            W, b = (tuple(arrays[f"{s}{i}"] for i in range(n)) for s in "Wb")
            return cls(weights=W, biases=b)
