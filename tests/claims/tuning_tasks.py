"""Designs for tasks that differ: version 1 of the env, each baseline on the same sealed tasks.

A pool of random designs, with the thesis's and that of `armside tune` on version 0, is tried on
every sealed task, on as many tasks of development, and on the nominal robot at the sealed tasks,
which costs no run of a robot. Searches choose from the pool by the tracker; what they reach is the
ground truth. Selection of the best of a pool favours it by noise alone: here that of the tracker.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from armside.arrays import Array
from armside.scripts.studies.search import random_designs
from armside.sim.laser.design import THESIS, Design
from armside.sim.notes import Tally
from armside.sim.robot.individual import Individual
from armside.sim.tuning.episode_task import TEST_SEEDS
from armside.sim.tuning.objective import mean_interval
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.situation import Situation, restarted

from ._engine import Check, Claim, Row, Rows, all_hold
from ._episodes import searched

POOL = 32
"""Designs, the first two of them known."""
FIRST_OF_DEVELOPMENT = 20_000
UPDATES = 5
RUNS = UPDATES + 1  # of a design on a robot: the last is held
LARGEST = 5.0
"""Logarithm of a ratio that stands for divergence, as the reward of the env has it."""
RIDGE = 0.1
"""Regularisation of the regression over the number of its tasks. ESTIMATE, not tuned."""
THE_THESIS, NOTHING, RANDOM = "thesis design", "nothing", "random design in every step"
BY_TUNE, BY_RANDOM = "design of armside tune", "fixed, by random search on other tasks"
HINDSIGHT, CONTEXT = "best fixed design, in hindsight", "contextual, regression on other tasks"
NOMINAL, NOMINAL_3 = "best on the nominal robot", "best three on the nominal robot"
RANDOM_3, CONSTRAINED_3 = "random search, three designs", "three, criterion below 1"
ORACLE = "each task's best of the pool"


def pool() -> list[Design]:
    designs = random_designs(Rules(version=1), 0)
    return [THESIS, searched(), *(next(designs) for _ in range(POOL - 2))]


def cases(seeds: Sequence[int]) -> Iterator[tuple[str, int]]:
    for kind in ("development", "sealed"):
        yield from ((kind, seed) for seed in seeds)


def run(case: tuple[str, int], tally: Tally) -> Iterator[Row]:
    kind, seed = case
    rules = Rules(version=1, sealed=kind == "sealed")
    known = TEST_SEEDS[seed] if kind == "sealed" else FIRST_OF_DEVELOPMENT + seed
    rules.check_seed(known)
    task = rules.draw(np.random.default_rng(known))
    first, designs = rules.begin(task), pool()
    row = {
        "kind": kind,
        "seed": seed,
        "features": rules.observe(first)[-13:],  # position, speed, k, payload, radius, shape
        "logs": np.array([_logs(rules, first, [design] * UPDATES) for design in designs]),
        "criterion": np.array([rules.criterion(design) for design in designs]),
    }
    tally.add(first.notes)
    if kind == "sealed":
        given = rules.draw(np.random.default_rng(known), {"individual": Individual()})
        nominal = rules.begin(given)
        each = [_logs(rules, nominal, [design] * UPDATES)[0] for design in designs]
        drawn = random_designs(rules, known)
        steps = [next(drawn) for _ in range(UPDATES)]
        row |= {"nominal": np.array(each), "random": _logs(rules, first, steps)}
    yield row


def _logs(rules: Rules, first: Situation, steps: Sequence[Design]) -> tuple[float, float]:
    """Logarithm of the tool's RMS over that before learning, by the tracker and by truth: the worse
    of the last run and of that with the last design held."""
    now = restarted(first)
    for design in steps:
        now = rules.advance(now, design)
        if now.diverged:
            return LARGEST, LARGEST
    held = rules.held(now, rules.predicted(now, steps[-1])[0])
    if held.diverged:
        return LARGEST, LARGEST
    worse = max(now, held, key=lambda one: one.measured.rms)
    measured = np.log(worse.measured.rms / first.measured.rms)
    true = np.log(worse.true.rms / first.true.rms)
    return float(min(measured, LARGEST)), float(min(true, LARGEST))


def reached(rows: Rows) -> Mapping[str, tuple[Array, float]]:
    """Of each baseline the logarithm of its ratio on the sealed tasks (n,), and the runs of robots
    that it took for each of them."""
    kinds = rows.by("kind")
    other, sealed = kinds["development"], kinds["sealed"]
    seen, true = sealed["logs"][:, :, 0], sealed["logs"][:, :, 1]
    bad = sealed["criterion"] >= 1.0
    n, tasks = len(sealed), np.arange(len(sealed))
    shared = RUNS * seen.shape[1]
    by_model = np.where(bad, np.inf, sealed["nominal"])

    def best(among: np.ndarray) -> Array:
        """Of each task, the best by the tracker among some designs (n, m)."""
        chosen = np.take_along_axis(seen, among, axis=1).argmin(axis=1)
        return true[tasks, among[tasks, chosen]]

    ranked, order = by_model.argsort(axis=1), np.tile(np.arange(seen.shape[1]), (n, 1))
    allowed, drawn = order[:, ~bad[0]], order[:, 2:]
    fixed = other["logs"][:, :, 0].mean(axis=0).argmin()
    hindsight = np.where(bad, np.inf, true).mean(axis=0).argmin()
    context = np.where(bad, np.inf, _predicted(other, sealed)).argmin(axis=1)
    return {
        NOTHING: (np.zeros(n), 0),
        THE_THESIS: (true[:, 0], 0),
        RANDOM: (sealed["random"][:, 1], 0),
        BY_TUNE: (true[:, 1], 0),
        BY_RANDOM: (true[:, fixed], shared * len(other) / n),
        CONTEXT: (true[tasks, context], shared * len(other) / n),
        HINDSIGHT: (true[:, hindsight], shared),
        NOMINAL: (true[tasks, ranked[:, 0]], 0),
        NOMINAL_3: (best(ranked[:, :3]), 3 * RUNS),
        RANDOM_3: (best(drawn[:, :3]), 3 * RUNS),
        CONSTRAINED_3: (best(drawn[:, ~bad[0, 2:]][:, :3]), 3 * RUNS),
        ORACLE: (best(allowed), shared),
    }


def _predicted(other: Rows, sealed: Rows) -> Array:
    """(n, m) logarithms that a ridge regression on the features predicts for each design."""
    x, y = other["features"], other["logs"][:, :, 0]
    mean, spread = x.mean(axis=0), x.std(axis=0) + 1e-9
    A, B = ((each - mean) / spread for each in (x, sealed["features"]))
    damped = A.T @ A + RIDGE * len(A) * np.eye(A.shape[1])
    return y.mean(axis=0) + B @ np.linalg.solve(damped, A.T @ (y - y.mean(axis=0)))


def shown(rows: Rows) -> Iterator[Row]:
    found = reached(rows)
    for name, (logs, runs) in found.items():
        yield {
            "baseline": name,
            "RMS after / before, geometric mean": float(np.exp(logs.mean())),
            "over the thesis design's (95 % interval)": against(logs, found[THE_THESIS][0]),
            "over the best fixed design's": against(logs, found[HINDSIGHT][0]),
            "worst after / before": float(np.exp(logs.max())),
            "robot runs of the search, for each task": f"{runs:.0f}",
        }


def against(one: Array, other: Array) -> str:
    """Geometric mean of one over the other in the same tasks, and its interval."""
    if one is other:
        return "-"
    mean, low, high = np.exp([(one - other).mean(), *mean_interval(one - other)])
    return f"{mean:.2f} ({low:.2f} to {high:.2f})"


def checks(rows: Rows) -> Iterator[Check]:
    found = {name: logs for name, (logs, _) in reached(rows).items()}
    for name, other, words in (
        (
            ORACLE,
            HINDSIGHT,
            "tasks differ: the best design of each leaves less than the best fixed",
        ),
        (NOMINAL_3, RANDOM_3, "of three designs those of the nominal robot leave less than random"),
    ):
        _, high = mean_interval(found[name] - found[other])
        yield all_hold(f"{words} (95 % interval)", high < 0.0)


CLAIM = Claim(
    title="Tool RMS on {n} sealed tasks of version 1: the worse of update 5 and of update 20",
    seeds=100,
    cases=cases,
    run=run,
    checks=checks,
    shown=shown,
)
