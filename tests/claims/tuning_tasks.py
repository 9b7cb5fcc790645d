"""Designs for tasks that differ: version 1 of the env, each baseline on the same sealed tasks.

Whatever is learned or searched for all tasks takes BUDGET runs of robots on tasks of development:
two searches for one fixed design, a regression, and PPO (`armside train --robots 16 --steps 560`
with the seeds 30100, 31100 and 32100, in the folder `ppo`). A pool of random designs is tried on
every sealed task and, by the model of the motors, on the nominal robot there, which takes no run
of a robot. Choices are made by the tracker; what they reach is the ground truth.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.special import comb

from armside.arrays import Array
from armside.scripts.studies import study as studies
from armside.scripts.studies.search import evaluate, random_best, random_designs, run_trial
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.design import THESIS, Design
from armside.sim.laser.tool_measure import Source
from armside.sim.notes import Tally
from armside.sim.robot.individual import Individual
from armside.sim.tuning.episode_task import TEST_SEEDS, Task
from armside.sim.tuning.objective import Episode, Objective, foreseen, prepare
from armside.sim.tuning.policies import Network
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.situation import Situation, restarted
from armside.sim.tuning.tool_objective import DEFAULT, ToolObjective

from ._engine import Check, Claim, Row, Rows, all_hold
from ._seeds import bootstrap

POOL = 12
"""Designs with a criterion below 1, the first of them the thesis's."""
UPDATES = 5
RUNS = UPDATES + 1  # of a design on a robot: the last is held
OTHERS, EACH = range(20_000, 20_040), 3
"""Tasks of development that the regression learns from, and designs of the pool on each."""
SEARCHED = range(20_100, 20_106)
"""Tasks of development of the two searches for a fixed design."""
BUDGET = len(OTHERS) * EACH * RUNS
LARGEST = 5.0
"""Logarithm of a ratio that stands for divergence and for a criterion of 1 or more, as the reward
of the env has it."""
LENGTH, NOISE = 1.5, 0.5
"""Of the regression: length of the kernel in standard deviations of the features, and standard
deviation of the noise over that of the data. Of 24 pairs the best where each task of
development is left out in turn."""
TOOLS = 12
"""Sealed tasks that are learned from the estimate of the tool too, which takes longest."""
PPO_RUNS = 112 * RUNS  # 560 steps are 112 episodes
PPO = sorted((Path(__file__).parent / "ppo").glob("*.npz"))
NOTHING, THE_THESIS, RANDOM = "nothing", "thesis design", "random design in every step"
BY_RANDOM, BY_OPTUNA = "fixed, random search", "fixed, Optuna"
HINDSIGHT, CONTEXT = "best fixed design, in hindsight", "contextual, regression"
NOMINAL, NOMINAL_3 = "best by the model", "best of three by the model"
RANDOM_3, ORACLE = "best of three at random", "each task's best design"


@cache
def pool() -> tuple[Design, ...]:
    rules = Rules(version=1)
    allowed = (d for d in random_designs(rules, 0) if rules.criterion(d) < 1.0)
    return THESIS, *islice(allowed, POOL - 1)


@cache
def fixed() -> tuple[Design, Design]:
    """Designs that random search and Optuna find with BUDGET runs on the same tasks."""
    rules = Rules(version=1)
    jobs = prepare(rules, SEARCHED, {})
    with TemporaryDirectory() as folder, Objective(rules, jobs) as objective:
        random = random_best(objective, BUDGET, SEARCHED[0])
        url = f"sqlite:///{folder}/a.db"
        study = studies.open_study(url, "a", {}, sampler="tpe", pruner="none", seed=SEARCHED[0])
        end = objective.runs + BUDGET
        while objective.runs < end:
            run_trial(study, partial(evaluate, objective))
        return random, studies.design_from(studies.bests(study)[-1].params)


def cases(seeds: Sequence[int]) -> Iterator[tuple[str, int]]:
    yield from (("development", seed) for seed in OTHERS)
    yield from ((kind, seed) for kind in ("sealed", "ppo") for seed in seeds)
    yield from (("tool", seed) for seed in seeds[:TOOLS])


def run(case: tuple[str, int], tally: Tally) -> Iterator[Row]:
    kind, seed = case
    sealed = kind != "development"
    rules, known = Rules(version=1, sealed=sealed), TEST_SEEDS[seed] if sealed else seed
    rules.check_seed(known)
    drawn = rules.draw(np.random.default_rng(known))
    if kind == "tool":
        yield {"kind": kind, "seed": seed, "logs": _of_tool(rules, drawn)}
        return
    first = rules.begin(drawn)
    tally.add(first.notes)
    row = {"kind": kind, "seed": seed, "features": features(first)}
    if not sealed:
        own = np.random.default_rng([seed, 1]).choice(POOL, EACH, replace=False)
        logs = [_logs(rules, first, always(pool()[i]))[0] for i in own]
        yield row | {"designs": own, "logs": np.array(logs)}
        return
    if kind == "ppo":
        yield row | {"logs": np.array([_logs(rules, first, _policy(rules, f)) for f in PPO])}
        return
    given = rules.draw(np.random.default_rng(known), {"individual": Individual()})
    nominal = rules.begin(given)
    ahead = [np.log(foreseen(rules, nominal, d).measured.rms) for d in pool()]
    steps = random_designs(rules, known)
    yield row | {
        "logs": np.array([_logs(rules, first, always(d)) for d in (*pool(), *fixed())]),
        "ahead": np.array(ahead),
        "random": np.array(_logs(rules, first, lambda _: next(steps))),
    }


def always(design: Design) -> Callable[[Situation], Design]:
    return lambda now: design


def _policy(rules: Rules, file: Path) -> Callable[[Situation], Design]:
    network = Network.load(file)
    return lambda now: rules.decision(network(rules.observe(now)))  # type: ignore[return-value]


def _of_tool(rules: Rules, drawn: Task) -> float:
    """As `_logs` by truth, for the law of `armside laser --measure estimate`, without a search."""
    with ToolObjective(
        rules, [Episode(*rules.prepared(drawn, ImuCfg()))], source=Source.ESTIMATE
    ) as objective:
        return float(np.log(objective.ratio(DEFAULT).true))


def features(first: Situation) -> Array:
    """What a controller knows of a task: turns per second, speed, payload, joints at the start."""
    task: Task = first.task
    turns = task.speed / (2.0 * np.pi * task.radius)
    known = [np.log(turns), np.log(task.speed), task.payload or 0.0]
    return np.array([*known, *first.experiment.loaded.reference[0]])


def _logs(
    rules: Rules, first: Situation, choose: Callable[[Situation], Design]
) -> tuple[float, float, float]:
    """Logarithm of the tool's RMS over that before learning, by the tracker and by truth: the worse
    of the last run and of that with the last design held; and the criterion of that design."""
    now, design = restarted(first), THESIS
    for _ in range(UPDATES):
        design = choose(now)
        now = rules.advance(now, design)
        if now.diverged:
            return LARGEST, LARGEST, rules.criterion(design)
    held = rules.held(now, design)
    criterion = rules.criterion(design)
    if held.diverged or criterion >= 1.0:
        return LARGEST, LARGEST, criterion
    worse = max(now, held, key=lambda one: one.measured.rms)
    seen = np.log(worse.measured.rms / first.measured.rms)
    true = np.log(worse.true.rms / first.true.rms)
    return float(min(seen, LARGEST)), float(min(true, LARGEST)), criterion


class Reached(dict[str, tuple[Array, Array, int, int]]):
    """Of each baseline: logarithm of its ratio (n,), criterion of its designs (n,), runs of robots
    on other tasks, and for each task."""

    def logs(self, name: str) -> Array:
        return self[name][0]


def reached(rows: Rows) -> Reached:
    sealed = rows.by("kind")["sealed"]
    seen, true, criterion = np.moveaxis(sealed["logs"], 2, 0)
    n, m = seen.shape
    tasks, random, ppo = np.arange(n), sealed["random"], rows.by("kind")["ppo"]["logs"]

    def best(among: np.ndarray) -> tuple[Array, Array]:
        """Of each task, the best by the tracker among some designs (n, k)."""
        own = among[tasks, np.take_along_axis(seen, among, axis=1).argmin(axis=1)]
        return true[tasks, own], criterion[tasks, own]

    def column(i: int) -> tuple[Array, Array]:
        return true[:, i], criterion[:, i]

    ranked = sealed["ahead"].argsort(axis=1)
    chosen = predicted(rows.by("kind")["development"], sealed["features"]).argmin(axis=1)
    drawn = expected(rows, 3), np.full(n, criterion[:, :POOL].max())
    found = Reached()
    found[NOTHING] = np.zeros(n), np.full(n, np.nan), 0, 0
    found[THE_THESIS] = *column(0), 0, 0
    found[RANDOM] = random[:, 1], random[:, 2], 0, 0
    found[BY_RANDOM], found[BY_OPTUNA] = ((*column(POOL + i), BUDGET, 0) for i in range(2))
    for i in range(ppo.shape[1]):
        found[f"PPO, seed {i}"] = ppo[:, i, 1], ppo[:, i, 2], PPO_RUNS, 0
    found[CONTEXT] = *best(chosen[:, np.newaxis]), BUDGET, 0
    found[HINDSIGHT] = *column(int(true.mean(axis=0).argmin())), 0, m * RUNS
    found[NOMINAL] = *best(ranked[:, :1]), 0, 0
    found[NOMINAL_3] = *best(ranked[:, :3]), 0, 3 * RUNS
    found[RANDOM_3] = *drawn, 0, 3 * RUNS
    found[ORACLE] = *best(np.tile(np.arange(m), (n, 1))), 0, m * RUNS
    return found


def expected(rows: Rows, k: int) -> Array:
    """(n,) logarithm that the best by the tracker of k random designs of the pool reaches, mean
    over all ways to draw them."""
    seen, true, _ = np.moveaxis(rows.by("kind")["sealed"]["logs"][:, :POOL], 2, 0)
    ordered = np.take_along_axis(true, seen.argsort(axis=1), axis=1)
    places = np.arange(POOL)
    return ordered @ (comb(POOL - 1 - places, k - 1) / comb(POOL, k))


def designs_for(target: Array, random: Array) -> float:
    """How many random designs reach the mean of a target (n,), between whole numbers linearly.

    random: (POOL, n), of `expected` for 1, 2, ... designs.
    """
    means = random.mean(axis=1)
    return float(np.interp(-target.mean(), -means, np.arange(1.0, len(means) + 1.0)))


def predicted(other: Rows, asked: Array) -> Array:
    """(n, POOL) logarithms that kernel regression predicts for each design on tasks (n, p)."""

    def joined(tasks: Array, own: np.ndarray) -> Array:
        """Features of tasks (n, p) with designs (n, m) each, (n m, p + 3)."""
        parts = np.repeat(tasks, own.shape[1], axis=0), designs[own.ravel()]
        return np.hstack(parts)

    designs = np.array([[d.gamma[0], d.delta[0], np.log(d.cutoff[0])] for d in pool()])
    x, y = joined(other["features"], other["designs"]), other["logs"].ravel()
    every = np.tile(np.arange(POOL), (len(asked), 1))
    mean, spread = x.mean(axis=0), x.std(axis=0) + 1e-9
    A, B = ((each - mean) / spread for each in (x, joined(asked, every)))

    def kernel(a: Array) -> Array:
        far = ((a[:, np.newaxis] - A[np.newaxis]) ** 2).sum(axis=2)
        return np.exp(-0.5 * far / (LENGTH**2 * A.shape[1]))

    weights = np.linalg.solve(kernel(A) + NOISE**2 * np.eye(len(A)), y - y.mean())
    return (y.mean() + kernel(B) @ weights).reshape(len(asked), POOL)


def shown(rows: Rows) -> Iterator[Row]:
    found = reached(rows)
    for name, (logs, criterion, others, each) in found.items():
        yield {
            "baseline": name,
            "RMS after / before, geometric mean": float(np.exp(logs.mean())),
            "over the thesis design's (95 % interval)": against(logs, found.logs(THE_THESIS)),
            "over the best fixed design's": against(logs, found.logs(HINDSIGHT)),
            "worst after / before": float(np.exp(logs.max())),
            "largest criterion": float(criterion.max()),
            "robot runs on other tasks": others,
            "on each task": each,
        }
    tool = rows.by("kind")["tool"]["logs"]
    for name, logs in (("learning from the estimate", tool), (ORACLE, found.logs(ORACLE))):
        own = logs[: len(tool)]
        yield {
            "baseline": f"{name}, first {len(tool)} tasks",
            "RMS after / before, geometric mean": float(np.exp(own.mean())),
            "over the thesis design's (95 % interval)": against(
                own, found.logs(THE_THESIS)[: len(own)]
            ),
            "over the best fixed design's": against(own, found.logs(HINDSIGHT)[: len(own)]),
            "worst after / before": float(np.exp(own.max())),
            "largest criterion": np.nan,
            "robot runs on other tasks": 0,
            "on each task": RUNS if logs is tool else found[ORACLE][3],
        }


def against(one: Array, other: Array) -> str:
    """Geometric mean of one over the other in the same tasks, and its interval."""
    if one is other:
        return "-"
    mean, low, high = np.exp([(one - other).mean(), *bootstrap(one - other)])
    return f"{mean:.2f} ({low:.2f} to {high:.2f})"


def checks(rows: Rows) -> Iterator[Check]:
    found = reached(rows)
    fixed = min((BY_RANDOM, BY_OPTUNA), key=lambda name: found.logs(name).mean())
    for name, other, words in (
        (
            ORACLE,
            HINDSIGHT,
            "tasks differ: the best design of each leaves less than the best fixed",
        ),
        (
            CONTEXT,
            fixed,
            "a contextual policy leaves less than the better fixed design of as many runs",
        ),
        (NOMINAL_3, RANDOM_3, "of three designs those by the model leave less than random ones"),
    ):
        _, high = bootstrap(found.logs(name) - found.logs(other))
        yield all_hold(f"{words} (95 % interval)", high < 0.0)
    random, target = (
        np.array([expected(rows, k) for k in range(1, POOL + 1)]),
        found.logs(NOMINAL_3),
    )
    rng, n = np.random.default_rng(0), len(target)
    drawn = (rng.integers(n, size=n) for _ in range(1000))
    low, high = np.quantile([designs_for(target[i], random[:, i]) for i in drawn], (0.025, 0.975))
    needs = f"{designs_for(target, random):.1f} designs (95 % interval {low:.1f} to {high:.1f})"
    yield all_hold(f"for what three by the model reach, random search needs {needs}", low > 3.0)
    tool = rows.by("kind")["tool"]["logs"]
    ratio, least = np.exp(tool.mean()), np.exp(found.logs(ORACLE)[: len(tool)].mean())
    words = f"on the first {len(tool)} tasks {ratio:.3f}, and each task's best design {least:.3f}"
    less = "learning from the estimate leaves less than the best design of the motors in each task"
    yield all_hold(f"{less}: {words}", tool < found.logs(ORACLE)[: len(tool)])
    won = [criterion[logs < 0.0].max(initial=0.0) for logs, criterion, *_ in found.values()]
    yield all_hold(
        "no design with a criterion of 1 or more leaves less than nothing", max(won) < 1.0
    )


CLAIM = Claim(
    title="Tool RMS on {n} sealed tasks of version 1: the worse of update 5 and of update 20",
    seeds=100,
    cases=cases,
    run=run,
    checks=checks,
    shown=shown,
)
