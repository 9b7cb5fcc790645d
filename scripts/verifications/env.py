"""The claim of `armside verify env`: the tuning env returns elements of its spaces."""

from collections.abc import Iterable
from itertools import cycle, islice

import numpy as np

from armside.sim.evaluation.check import Table, all_hold
from armside.sim.notes import Tally
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

AT_ONCE = 50
KINDS = (
    {"robot": "large", "motors": "shared", "reward": "tracker"},
    {"robot": "large", "motors": "each", "reward": "motor"},
    {"robot": "irb1400", "motors": "each", "reward": "tracker"},
    {"robot": "irb1400", "motors": "shared", "reward": "motor"},
)


def env(seeds: Iterable[int]) -> Table:
    """One episode of random actions per seed, batched; the kinds of env take turns."""
    rows, remaining, kinds, said = [], iter(seeds), cycle(KINDS), Tally()
    while batch := list(islice(remaining, AT_ONCE)):
        kind = next(kinds)
        rows.append((f"{batch[0]}-{batch[-1]}", *kind.values(), *_row(kind, batch, said)))
    return Table(
        "Random actions: what the tuning env returns lies in its spaces",
        (
            *("seeds", "robot", "motors", "reward"),
            *("returned", "outside of the space", "largest entry", "entries at a bound [%]"),
            *("smallest reward", "largest reward", "diverged"),
        ),
        rows,
        [
            all_hold("every observation lies in the observation space", [r[5] == 0 for r in rows]),
            all_hold("every reward lies in [-5, 5]", [-5 <= r[8] <= r[9] <= 5 for r in rows]),
        ],
        said.notes("runs"),
    )


def _row(kind: dict[str, str], seeds: list[int], said: Tally) -> tuple[float, ...]:
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
    said.include(cells.tally)
    each, reward = np.concatenate(seen), np.concatenate(rewards)
    outside = sum(not cells.single_observation_space.contains(row) for row in each)
    at_bound = 100.0 * float((np.abs(each) == 1.0).mean())
    largest, low, high = map(float, (np.abs(each).max(), reward.min(), reward.max()))
    return (len(each), outside, largest, at_bound, low, high, diverged)
