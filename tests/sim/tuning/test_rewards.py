"""Rewards, budgets and sealed seeds of the tuning env, on made-up situations."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from armside.sim.tuning import episode_task as task
from armside.sim.tuning import situation
from armside.sim.tuning.action import VARIABLES, Scale
from armside.sim.tuning.episode_task import PAYLOADS, POSE_SPREAD, SPEEDS, TEST_SEEDS
from armside.sim.tuning.rules import WORST_REWARD, Rules
from armside.sim.tuning.situation import Reading, RewardSensor


@pytest.fixture(scope="module")
def rules():
    return Rules()


def seen(rms, diverged=False, k=1):
    return SimpleNamespace(measured=SimpleNamespace(rms=rms), diverged=diverged, k=k)


@pytest.mark.parametrize(
    ("before", "after", "decrease", "reward"),
    [
        (2e-4, 1e-4, np.log(2.0), np.log(2.0)),
        (1e-4, 2e-4, -np.log(2.0), -np.log(2.0)),
        (1.0, np.exp(-4.99), 4.99, 4.99),
        (1.0, np.exp(-5.01), 5.01, 5.0),
        (np.exp(-5.01), 1.0, -5.01, -5.0),
        (1.0, np.nan, np.nan, 0.0),
        (0.0, 1.0, np.nan, 0.0),
    ],
)
def test_a_reward_is_the_decrease_of_the_log_error_within_five(
    rules, before, after, decrease, reward
):
    found = rules.score(seen(before), seen(after))
    assert found == pytest.approx((decrease, reward), nan_ok=True)


def test_divergence_has_the_worst_reward_whatever_the_error(rules):
    assert WORST_REWARD == -5.0
    found = rules.score(seen(1.0), seen(0.1, diverged=True))
    assert found == pytest.approx((np.log(10.0), -5.0))


def test_an_episode_ends_with_its_budget_of_five(rules):
    assert rules.iterations == 5
    ends = [rules.truncated(seen(1.0, k=k)) for k in (4, 5, 6)]
    assert ends == [False, True, True]
    assert not rules.truncated(seen(1.0, diverged=True, k=5))


def test_seeds_of_tests_are_sealed_on_both_sides(rules):
    sealed = replace(rules, sealed=True)
    for seed in (TEST_SEEDS[0], TEST_SEEDS[-1]):
        with pytest.raises(ValueError, match="sealed"):
            rules.check_seed(seed)
        assert sealed.check_seed(seed) == seed
    for seed in (0, TEST_SEEDS[0] - 1, TEST_SEEDS[-1] + 1):
        assert rules.check_seed(seed) == seed
        with pytest.raises(ValueError, match="sealed"):
            sealed.check_seed(seed)
    assert len(TEST_SEEDS) == 100


def test_ranges_of_actions_and_tasks_are_the_documented_ones():
    gamma, delta, cutoff = VARIABLES
    assert (gamma.low, gamma.high, gamma.scale) == (0.1, 1.5, Scale.LINEAR)
    assert (delta.low, delta.high, delta.scale) == (0.0, 25.0, Scale.WHOLE)
    assert (cutoff.low, cutoff.high, cutoff.scale) == (1.0, 30.0, Scale.LOGARITHMIC)
    assert cutoff.physical(np.zeros(1)) == pytest.approx(np.sqrt(30.0))
    drawn = task.draw("large", np.random.default_rng(0))
    assert (SPEEDS, POSE_SPREAD) == ((0.020, 0.060), 0.050)
    assert (drawn.shape, drawn.radius) == ("circle", 0.005)
    assert PAYLOADS == {"large": (20.0, 80.0)}


def test_an_individual_has_a_stream_of_its_own_for_its_parameters(rules, monkeypatch):
    """Apart from those of noise and set-up, which `prepare` spawns from the same number."""
    drawn, prepared = [], []
    monkeypatch.setattr(
        task.spread, "draw", lambda rng, _: drawn.append(rng.standard_normal()) or "robot"
    )
    monkeypatch.setattr(task, "prepare", lambda cut, **given: prepared.append((cut, given)))
    for individual in (3, 3, 4):
        given = {"pose": "p1", "individual": individual, "speed": 0.03, "payload": 50.0}
        made = task.draw("large", np.random.default_rng(0), given)
        task.experiment("large", rules.nominal, made)
    assert drawn[0] == drawn[1] != drawn[2]
    own = np.random.default_rng(np.random.SeedSequence(3).spawn(1)[0]).standard_normal()
    assert own != drawn[0]
    assert [given["seed"] for _, given in prepared] == [3, 3, 4]
    cut, _ = prepared[0]
    assert (cut.individual, cut.speed, cut.payload, cut.radius) == ("robot", 0.03, 50.0, 0.005)


def test_an_iteration_learns_from_the_last_correction_and_its_arm_side_error(rules, monkeypatch):
    u, e = np.ones((4, 6)), np.full((4, 6), 2.0)
    ran = []
    plant = SimpleNamespace(run=lambda correction: ran.append(correction) or "cut")
    now = SimpleNamespace(
        task=None,
        experiment=SimpleNamespace(plant=plant),
        reading=None,
        k=2,
        correction=u,
        error=e,
        motor_error=100.0 * e,
        first_norm="first",
        centre=np.full((4, 6), 0.25),
        twin="twin",
    )
    made = []
    monkeypatch.setattr(situation, "_situation", lambda *given: made.append(given))
    rules.advance(now, SimpleNamespace(law=lambda u, e: u + 0.5 * e))
    assert ran[0] == pytest.approx(u + 0.5 * e)
    ((_, _, _, k, correction, cut, first, twin),) = made
    assert (k, cut, first, twin) == (3, "cut", "first", "twin")
    assert correction is ran[0]


def test_each_sensor_of_the_reward_reads_its_own_signal(monkeypatch):
    """The tracker its samples; motors the rigid arm at r and y, added to the programmed path."""
    given = []
    monkeypatch.setattr(situation, "tool_error", lambda *signals: given.append(signals))
    tracker = SimpleNamespace(time="tracker time", position="tracker position")

    def at(phi):
        pose = np.tile(np.eye(4), (2, 1, 1))
        pose[:, :3, 3] = phi[:, :3]
        return pose

    monkeypatch.setattr(situation, "_compiled", lambda robot: SimpleNamespace(pose=at))
    r, y = np.zeros((2, 6)), np.full((2, 6), 1e-3)
    log = SimpleNamespace(time="log time", reference=r, motor_angle=y)
    cut: Any = SimpleNamespace(tracker=tracker, recording=log)
    motion: Any = SimpleNamespace(position=np.ones((2, 3)))
    robot: Any = None
    for sensor in (RewardSensor.TRACKER, RewardSensor.MOTOR):
        Reading(sensor, motion, robot)(cut)
    assert given[0] == (motion, "tracker time", "tracker position")
    assert given[1][1] == "log time"
    assert given[1][2] == pytest.approx(np.full((2, 3), 1.001))
