"""Policies, and their evaluation and that of a design: whole episodes, against ground truth."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.arrays import Array, npz

from ..laser.design import Design
from ..notes import Note
from .action import SIX, Motors, action_of
from .rules import Decision, Rules


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


Policy = Callable[[np.ndarray], np.ndarray]
"""From an observation to an action, as the spaces of `Rules` have them."""


@dataclass(frozen=True)
class Episode:
    """Outcome of one episode."""

    seed: int
    rms_true: Array
    """(K + 1,) [m], of the tool after each run; ends early where learning diverged."""
    rms_measured: Array
    """(K + 1,) [m], the same as measured by the configured sensor."""
    decisions: tuple[Decision, ...]
    """(K,), designs or corrections that were taken."""
    diverged: bool
    notes: tuple[tuple[Note, ...], ...] = ()
    """Limits that changed each run."""

    @property
    def ratio(self) -> float:
        """RMS of the tool after the last run over that before learning."""
        return float(self.rms_true[-1] / self.rms_true[0])


def run_episode(rules: Rules, seed: int, policy: Policy) -> Episode:
    """The episode of `reset(seed=seed)`, with the policy's actions. Raises as the env."""
    rules.check_seed(seed)
    situation = rules.begin(rules.draw(np.random.default_rng(seed)))
    runs, decisions = [situation], list[Decision]()
    while not (situation.diverged or rules.truncated(situation)):
        decision = rules.decision(policy(rules.observe(situation)))
        situation = rules.advance(situation, decision)
        decisions.append(decision)
        runs.append(situation)
    return Episode(
        seed,
        rms_true=np.array([run.true.rms for run in runs]),
        rms_measured=np.array([run.measured.rms for run in runs]),
        decisions=tuple(decisions),
        diverged=situation.diverged,
        notes=tuple(tuple(run.all_notes) for run in runs),
    )


def evaluate(
    rules: Rules, seeds: Sequence[int], policy: Policy, *, threads: int = 1
) -> Iterator[Episode]:
    """The episodes of these seeds, in their order. Raises as `run_episode` does."""
    with ThreadPoolExecutor(threads) as pool:
        yield from pool.map(lambda seed: run_episode(rules, seed, policy), seeds)


def always(design: Design, motors: Motors, n_axes: int = SIX) -> Policy:
    """The policy that takes the same design in each iteration. Raises ValueError as `action_of`."""
    action = action_of(design, motors, n_axes)
    return lambda observed: action
