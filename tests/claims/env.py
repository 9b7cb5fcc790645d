"""The tuning env returns elements of its spaces: an episode of random actions per seed."""

from collections.abc import Iterator, Sequence
from itertools import cycle

import numpy as np

from armside.sim.tuning.vector_env import IlcTuningVectorEnv

from ._engine import Check, Claim, Row, Rows, Tally, all_hold

AT_ONCE = 50
KINDS = (
    ("large", "shared", "tracker"),
    ("large", "each", "motor"),
    ("irb1400", "each", "tracker"),
    ("irb1400", "shared", "motor"),
)
"""Robot, motors and reward of the kinds of env, which take turns."""


def cases(seeds: Sequence[int]) -> Iterator[tuple[tuple[str, str, str], tuple[int, ...]]]:
    batches = (tuple(seeds[i : i + AT_ONCE]) for i in range(0, len(seeds), AT_ONCE))
    yield from zip(cycle(KINDS), batches, strict=False)


def run(case: tuple[tuple[str, str, str], tuple[int, ...]], tally: Tally) -> Iterator[Row]:
    (robot, motors, reward), seeds = case
    cells = IlcTuningVectorEnv(len(seeds), robot=robot, motors=motors, reward=reward)
    cells.action_space.seed(seeds[0])
    observed, _ = cells.reset(seed=list(seeds))
    seen, rewards, diverged = [observed], [], 0
    for _ in range(cells.rules.iterations):
        observed, each, terminated, _, _ = cells.step(cells.action_space.sample())
        seen.append(observed)
        rewards.append(each)
        diverged += int(terminated.sum())
    cells.close()
    tally.include(cells.tally)
    every, found = np.concatenate(seen), np.concatenate(rewards)
    outside = sum(not cells.single_observation_space.contains(row) for row in every)
    yield {
        "seeds": f"{seeds[0]}-{seeds[-1]}",
        **{"robot": robot, "motors": motors, "reward": reward},
        **{"returned": len(every), "outside of the space": outside},
        "largest entry": float(np.abs(every).max()),
        "entries at a bound [%]": 100.0 * float((np.abs(every) == 1.0).mean()),
        "smallest reward": float(found.min()),
        "largest reward": float(found.max()),
        "diverged": diverged,
    }


def checks(rows: Rows) -> Iterator[Check]:
    inside = rows["outside of the space"] == 0
    yield all_hold("every observation lies in the observation space", inside)
    low, high = rows["smallest reward"], rows["largest reward"]
    yield all_hold("every reward lies in [-5, 5]", (low >= -5) & (low <= high) & (high <= 5))


CLAIM = Claim(
    title="Random actions: what the tuning env returns lies in its spaces",
    seeds=1000,
    cases=cases,
    run=run,
    checks=checks,
    processes=1,
)
