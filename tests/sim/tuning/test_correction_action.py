"""Actions that are corrections: coefficients of a basis, for any number of axes."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from armside import assets
from armside.sim.tuning.action import CorrectionBasis
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

ID = "armside:armside/IlcTuning-v0"
TWO_LINK = str(assets.LARGE_ROBOT_XML.with_name("two_link.toml"))
HOW = {"robot": TWO_LINK, "action": "correction", "functions": 8}


@pytest.fixture(scope="module")
def before():
    rules = Rules(**HOW, iterations=3)
    return rules, rules.begin(rules.draw(np.random.default_rng(0)))


@pytest.mark.parametrize("kind", ["b-splines", "harmonics"])
def test_corrections_begin_and_end_at_zero_and_are_fitted_again(kind):
    basis, size = CorrectionBasis(kind, 6), np.array([1e-3, 2e-3])
    values = np.linspace(-1.0, 1.0, 12)
    u = basis.decoded(values, 2).correction(300, size)
    assert not u[[0, -1]].any()
    np.testing.assert_allclose(basis.fit(u, size).ravel(), values, atol=1e-12)


def test_the_spaces_follow_axes_and_functions(before):
    rules, situation = before
    assert rules.action_space.shape == (2 * 8,)
    assert rules.observation_space.shape == (8 * 2 + 2 + 2 * 2 * 8,)
    assert rules.observe(situation) in rules.observation_space


@pytest.mark.parametrize("basis", ["b-splines", "harmonics"])
def test_the_env_checker_has_nothing_to_say(basis):
    check_env(
        gymnasium.make(ID, iterations=2, basis=basis, **HOW).unwrapped, skip_render_check=True
    )


def test_the_same_action_is_the_same_correction_and_zero_is_none(before):
    rules, situation = before
    action = np.random.default_rng(1).uniform(-0.2, 0.2, 16)
    after = rules.advance(situation, rules.decision(action))
    seen = rules.observe(after)[-16:]
    np.testing.assert_allclose(seen, action, atol=1e-6)
    none = rules.advance(after, rules.decision(np.zeros(16)))
    assert not none.correction.any()


def test_adding_the_observed_error_is_learning(before):
    """The simplest law there is, u + e in the basis, by what the observation holds."""
    rules, situation = before
    first = situation.two_norm
    for _ in range(2):
        seen = rules.observe(situation)
        error, correction = seen[-32:-16], seen[-16:]
        action = np.clip(correction + 0.7 * error, -1.0, 1.0)
        situation = rules.advance(situation, rules.decision(action))
    assert (situation.two_norm < 0.7 * first).all()


def test_rows_of_the_vector_env_are_those_of_the_single_env():
    one = gymnasium.make(ID, iterations=1, **HOW)
    many = IlcTuningVectorEnv(2, iterations=1, threads=1, **HOW)
    action = np.full((2, 16), 0.1, np.float32)
    many.reset(seed=3)
    one.reset(seed=3)
    np.testing.assert_array_equal(many.step(action)[0][0], one.step(action[0])[0])
    many.close()


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (np.zeros(3), r"shape \(16,\)"),
        (np.full(16, np.nan), r"function 1 of axis 1"),
        (np.r_[np.zeros(9), 2.0, np.zeros(6)], r"function 2 of axis 2"),
        ("none", "must be 16 numbers"),
    ],
)
def test_an_action_that_is_none_is_refused(action, said, before):
    with pytest.raises(ValueError, match=said):
        before[0].decision(action)


@pytest.mark.parametrize("how", [{"basis": "wavelets"}, {"functions": 1}, {"action": "u"}])
def test_options_that_do_not_exist_are_refused(how):
    with pytest.raises(ValueError, match=r"basis|functions|action"):
        Rules(**(HOW | how))
