"""Sealed episodes of the tuning env by the baselines: designs and a policy.

`scripts/studies/tuned/` holds results of `armside tune` and `armside train`; docs/tuning.md has the
commands.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside import scripts
from armside.scripts.studies.study import load_design
from armside.sim.laser.design import THESIS, Design
from armside.sim.notes import Tally
from armside.sim.robot.run import cores
from armside.sim.tuning.action import VARIABLES, Motors
from armside.sim.tuning.episode_task import TEST_SEEDS
from armside.sim.tuning.policies import Network
from armside.sim.tuning.rules import Rules

from ._policies import Policy, always, evaluate

TUNED = Path(scripts.__file__).parent / "studies" / "tuned"
DATA_SEED = 1  # seed of the experiments that models are identified from
BY_THESIS, BY_SEARCH, BY_MODELS, BY_POLICY = (
    *("thesis design", "best fixed design by search"),
    *("designs from identified models", "learned policy"),
)


def policy(name: str) -> Policy:
    """The policy of a baseline."""
    match name:
        case "thesis design":
            return always(THESIS, Motors.SHARED)
        case "best fixed design by search":
            return always(searched(), Motors.SHARED)
        case "designs from identified models":
            return always(identified(), Motors.EACH)
        case _:
            return Network.load(TUNED / "policy.npz")


def episodes(
    seeds: Sequence[int], baselines: Mapping[str, Rules], tally: Tally
) -> Iterator[dict[str, Any]]:
    """Rows of the episodes of each baseline: seed i is the sealed episode TEST_SEEDS[i]."""
    sealed = [TEST_SEEDS[i] for i in seeds]
    for name, rules in baselines.items():
        for seed, episode in zip(
            seeds, evaluate(rules, sealed, policy(name), threads=cores()), strict=True
        ):
            for notes in episode.notes:
                tally.add(notes)
            yield {
                **{"baseline": name, "seed": seed, "diverged": episode.diverged},
                **{"ratio": episode.ratio, "rms": episode.rms_true},
                "gamma": [d.gamma[0] for d in episode.decisions if isinstance(d, Design)],
            }


def searched() -> Design:
    """The design that `armside tune` found."""
    return load_design(TUNED / "design.json")


def identified() -> Design:
    """A design for each motor from its own model, identified at p1, as `armside reproduce 9` does.

    Values beyond the ranges of the env are brought to their ends.
    """
    from armside.ilc.analysis.proposal import design_for
    from armside.scripts.thesis.chapter9.bands import SPEEDS, identify
    from armside.scripts.thesis.chapter9.designs import CUTOFFS
    from armside.scripts.thesis.chapter9.table import STUDIES

    jobs = STUDIES["identification"].jobs(DATA_SEED)
    results = {speed: jobs["p1", speed].run() for speed in SPEEDS}
    models = [identify(results, (motor,)) for motor in range(6)]
    proposals = [design_for(model.system, CUTOFFS, fit=model.fit) for model in models]
    gamma, delta, cutoff = (
        tuple(float(np.clip(getattr(p, v.name), v.low, v.high)) for p in proposals)
        for v in VARIABLES
    )
    return Design(gamma=gamma, delta=tuple(int(d) for d in delta), cutoff=cutoff)
