"""Claims of kinematics, env, tuning and sweep fail where one seed leaves its bar: `test_claims`."""

from collections import Counter
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from armside.scripts.verifications import (
    env,
    kinematics,
    sweep,
    tuning,
)
from armside.sim.laser.design import THESIS

from .verdicts import CLOSE, failing, fails_by_itself

# Kinematics, env, tuning, sweep


@pytest.mark.parametrize(
    ("column", "bar", "words"),
    [
        (0, 1e-13, "generated poses"),
        (1, 1e-11, "every branch has its pose"),
        (2, 0.5, "one branch is always"),
        (3, 1e-8, "Jacobians are derivatives"),
    ],
)
def test_kinematics_are_bounded(monkeypatch, column, bar, words):
    drawn = []

    def run(value):
        def row(robot, rng):
            drawn.append((robot.name, rng.uniform()))
            cells = [0.0, 0.0, 0, 0.0]
            if len(drawn) % 4 == 0:  # the last seed's last robot
                cells[column] = value
            return tuple(cells)

        monkeypatch.setattr(kinematics, "_row", row)
        return failing(kinematics.kinematics(range(2)))

    assert run(0 if column == 2 else bar * (1 - CLOSE)) == []
    fails_by_itself(run(1 if column == 2 else bar * (1 + CLOSE)), words)
    assert len(set(drawn[:4])) == 4  # each seed and robot draws its own
    assert kinematics.CONFIGURATIONS == 1000


@pytest.mark.parametrize(
    ("column", "inside", "outside", "words"),
    [
        (1, 0, 1, "every observation lies"),
        (4, -5.0, -5.01, "every reward lies"),
        (5, 5.0, 5.01, "every reward lies"),
    ],
)
def test_spaces_of_the_env_are_bounded(monkeypatch, column, inside, outside, words):
    def run(value):
        def row(_, seeds, said):
            cells = [100, 0, 1.0, 2.0, -1.0, 1.0, 0]
            if seeds[-1] == 119:
                cells[column] = value
            return tuple(cells)

        monkeypatch.setattr(env, "_row", row)
        return failing(env.env(range(120)))

    assert run(inside) == []
    fails_by_itself(run(outside), words)


@pytest.mark.parametrize("name", ["best fixed design by search", "learned policy"])
def test_a_better_design_is_better_by_three_standard_errors(monkeypatch, name):
    rng = np.random.default_rng(0)
    thesis = np.exp(0.2 * rng.standard_normal(50))
    noise = rng.standard_normal(50)
    noise = (noise - noise.mean()) / noise.std(ddof=1) / np.sqrt(1 / 50)  # standard error: 1

    def run(gain):
        """log(thesis) - log(name) has mean `gain` and standard error 1, in parts of 1e-3."""
        ratios = {
            "thesis design": thesis,
            "best fixed design by search": 0.5 * thesis,
            "designs from identified models": thesis,
            "learned policy": 0.5 * thesis,
        }
        ratios[name] = thesis / np.exp(1e-3 * (gain + noise))
        episodes = {
            which: [
                SimpleNamespace(ratio=r, rms_true=[1.0, r], diverged=False, notes=()) for r in all_
            ]
            for which, all_ in ratios.items()
        }
        monkeypatch.setattr(tuning, "searched", lambda: THESIS)
        monkeypatch.setattr(tuning, "identified", lambda: THESIS)
        monkeypatch.setattr(tuning, "_episodes", lambda seeds, baselines: episodes)
        return failing(tuning.tuning(range(50)))

    assert run(3.01) == []
    fails_by_itself(run(2.99), f"the {name} leaves less")


def test_sealed_episodes_are_counted_from_the_seeds(monkeypatch):
    asked = []
    monkeypatch.setattr(
        tuning,
        "evaluate",
        lambda rules, seeds, policy, threads: asked.append((rules.sealed, seeds)) or [],
    )
    from armside.sim.tuning.rules import Rules

    tuning._episodes([3, 5], {"a": (Rules(sealed=True), None)})  # pyright: ignore[reportArgumentType]
    assert asked == [(True, [tuning.TEST_SEEDS[3], tuning.TEST_SEEDS[5]])]


def test_a_searched_design_is_made_for_its_budget(monkeypatch):
    def run(tenth):
        falling = np.array([1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.5, 0.5, 0.5, 0.5, tenth])
        long = [SimpleNamespace(rms_true=falling, diverged=False, notes=()) for _ in range(3)]
        short = {"rms_true": falling[:6], "decisions": [THESIS] * 5}
        policy = [SimpleNamespace(diverged=False, notes=(), **short)] * 3
        episodes = {
            "thesis design": long,
            "best fixed design by search": long,
            "learned policy": policy,
        }
        monkeypatch.setattr(tuning, "_episodes", lambda seeds, baselines: episodes)
        return failing(tuning.iterations(range(3)))

    assert run(0.501) == []
    fails_by_itself(run(0.499), "after ten iterations it leaves more")


@pytest.mark.parametrize(
    ("taken_over", "computed", "equal", "words"),
    [
        (4, 8, True, ""),
        (3, 9, True, "no result on disk is lost"),
        (4, 9, True, "the rest is computed once"),
        (4, 8, False, "equals that of an undisturbed"),
    ],
)
def test_a_killed_sweep_is_resumed_without_loss(monkeypatch, taken_over, computed, equal, words):
    n = len(sweep.parse(sweep.AXES, 0))
    assert n == 36

    class Whole:
        def __init__(self, same):
            self.same = same

        def __len__(self):
            return n

        def equals(self, _):
            return self.same

    def dataset(folder):
        last = str(folder).endswith("1")
        return SimpleNamespace(last=last, read=lambda: Whole(equal or not last))

    def run_grid(grid, data, workers):
        known, done = (taken_over, computed) if data.last else (4, 8)
        return Counter({sweep.KNOWN: known, sweep.KNOWN_FAILED: 24, "done": done})

    process = SimpleNamespace(wait=lambda *_: None)
    monkeypatch.setattr(sweep, "_begun", lambda _: process)
    monkeypatch.setattr(sweep, "_kill", lambda *_: 28)
    monkeypatch.setattr(sweep, "dataset", dataset)
    monkeypatch.setattr(sweep, "run_grid", run_grid)
    monkeypatch.setattr(sweep, "Workers", lambda: nullcontext(None))
    found = failing(sweep.sweep(range(2)))
    if not words:
        assert found == []
    else:
        fails_by_itself(found, words)


@pytest.mark.parametrize(("growth", "holds"), [(1.099, True), (1.101, False)])
def test_memory_of_a_sweep_stays_within_a_tenth(monkeypatch, growth, holds):
    resident = iter([100.0, *[100.0] * 8, 100.0 * growth])
    monkeypatch.setattr(sweep, "_descendants", lambda _: [])
    monkeypatch.setattr(sweep, "_resident", lambda _: next(resident))
    monkeypatch.setattr(sweep, "Workers", lambda: nullcontext(None))

    def run_grid(grid, data, workers, step):
        for _ in range(20):
            step()
        return {"done": 20}

    monkeypatch.setattr(sweep, "run_grid", run_grid)
    assert (failing(sweep.memory(range(20))) == []) is holds
