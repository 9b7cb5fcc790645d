"""The claim of `armside verify env`: the spaces of the tuning env contain all that it returns."""

from collections.abc import Iterable, Iterator

import numpy as np

from armside.sim.tuning.vector_env import IlcTuningVectorEnv

from ..commands.verify import Table, Verdict

AT_ONCE = 50
KINDS = (
    {"robot": "large", "motors": "shared", "reward": "tracker"},
    {"robot": "large", "motors": "each", "reward": "motor"},
    {"robot": "irb1400", "motors": "each", "reward": "tracker"},
    {"robot": "irb1400", "motors": "shared", "reward": "motor"},
)


def env(seeds: Iterable[int]) -> Table:
    """One episode of random actions per seed, batched; the kinds of env take turns."""
    rows = []
    for n, chosen in enumerate(_batches(seeds)):
        kind = KINDS[n % len(KINDS)]
        rows.append((f"{chosen[0]}-{chosen[-1]}", *kind.values(), *_row(kind, chosen)))
    return Table(
        title="Random actions: what the tuning env returns lies in its spaces",
        columns=(
            *("seeds", "robot", "motors", "reward"),
            *("returned", "outside of the space", "largest entry", "entries at a bound [%]"),
            *("smallest reward", "largest reward", "diverged"),
        ),
        rows=rows,
        verdicts=(
            Verdict("every observation lies in the observation space", not any(r[5] for r in rows)),
            Verdict("every reward lies in [-5, 5]", all(-5 <= r[8] <= r[9] <= 5 for r in rows)),
        ),
    )


def _batches(seeds: Iterable[int]) -> Iterator[list[int]]:
    batch: list[int] = []
    for seed in seeds:
        batch.append(seed)
        if len(batch) == AT_ONCE:
            yield batch
            batch = []
    if batch:
        yield batch


def _row(
    kind: dict[str, str], seeds: list[int]
) -> tuple[int, int, float, float, float, float, int]:
    cells = IlcTuningVectorEnv(len(seeds), **kind)  # type: ignore[arg-type]
    cells.action_space.seed(seeds[0])
    observed, _ = cells.reset(seed=seeds)
    seen, rewards, diverged = [observed], [], 0
    for _ in range(cells.rules.iterations):
        observed, reward, terminated, _, _ = cells.step(cells.action_space.sample())
        seen.append(observed)
        rewards.append(reward)
        diverged += int(terminated.sum())
    cells.close()
    each = np.concatenate(seen)
    outside = sum(not cells.single_observation_space.contains(row) for row in each)
    at_bound = 100.0 * float((np.abs(each) == 1.0).mean())
    reward = np.concatenate(rewards)
    return (
        len(each),
        outside,
        float(np.abs(each).max()),
        at_bound,
        float(reward.min()),
        float(reward.max()),
        diverged,
    )
