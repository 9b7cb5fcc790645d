"""Design variables and the actions that stand for them."""

import re

import gymnasium
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside import assets
from armside.sim.laser.design import Design
from armside.sim.tuning.action import VARIABLES, CorrectionBasis, Motors, action_of, design_of
from armside.sim.tuning.env import IlcTuningEnv
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

ROUNDING = 1e-6
"""Relative, of a float32 action."""


def test_the_table_of_the_env_says_what_the_variables_are():
    rows = re.findall(
        r"^ +\| (\w+) \| ([\d.]+) \| ([\d.]+) \| .* \| ([\w ]+) \|$",
        IlcTuningEnv.__doc__ or "",
        re.M,
    )
    assert rows == [(v.name, f"{v.low:g}", f"{v.high:g}", v.scale.value) for v in VARIABLES]


@pytest.mark.parametrize("motors", list(Motors))
def test_the_ends_of_an_action_are_the_ends_of_the_ranges(motors):
    n = 3 * motors.count()
    for end, name in ((-1.0, "low"), (1.0, "high")):
        made = design_of(np.full(n, end), motors)
        for variable in VARIABLES:
            assert getattr(made, variable.name) == (getattr(variable, name),) * motors.count()


@given(st.lists(st.floats(-1, 1, width=32), min_size=18, max_size=18))
def test_every_action_is_a_law_within_the_ranges(action):
    made = design_of(np.array(action, np.float32), Motors.EACH)
    for variable in VARIABLES:
        values = np.array(getattr(made, variable.name))
        assert ((values >= variable.low) & (values <= variable.high)).all()
    made.law.check(300, 6)


def test_six_designs_reach_six_motors():
    cutoff = (5.0, 6.0, 7.0, 8.0, 9.0, 10.0)
    six = Design(gamma=(0.9,) * 6, delta=(1, 2, 3, 4, 5, 6), cutoff=cutoff)
    back = design_of(action_of(six, Motors.EACH), Motors.EACH)
    assert back.delta == (1, 2, 3, 4, 5, 6)
    assert back.cutoff == pytest.approx(cutoff, rel=ROUNDING)
    with pytest.raises(ValueError, match="share one design"):
        action_of(six, Motors.SHARED)


def test_a_design_outside_of_the_ranges_or_of_other_motors_is_no_action():
    with pytest.raises(ValueError, match=r"gamma must be in \[0.1, 1.5\]"):
        action_of(Design(gamma=(2.0,), delta=(3,), cutoff=(10.0,)), Motors.SHARED)
    two = design_of(np.zeros(6), Motors.EACH, 2)
    assert action_of(two, Motors.EACH, 2).shape == (6,)
    with pytest.raises(ValueError, match="gamma has 2 values, the robot 6 motors"):
        action_of(two, Motors.EACH)


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


def test_the_same_action_is_the_same_correction_and_zero_is_none(before):
    rules, situation = before
    action = np.random.default_rng(1).uniform(-0.2, 0.2, 16)
    after = rules.advance(situation, rules.decision(action))
    seen = rules.observe(after)
    assert seen in rules.observation_space
    np.testing.assert_allclose(seen[-16:], action, atol=1e-6)
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
    ("of", "action", "said"),
    [
        ("design", [0.0, 1.1, 0.0], r"\[-1, 1\], got 1.1 at index 1 \(delta\)"),
        ("design", [0.0, 0.0, -np.inf], r"got -inf at index 2 \(cutoff\)"),
        ("design", [np.nan, 0.0, 0.0], r"got nan at index 0 \(gamma\)"),
        ("design", [0.0, 0.0], r"shape \(3,\), got \(2,\)"),
        ("correction", np.zeros(3), r"shape \(16,\)"),
        ("correction", np.full(16, np.nan), r"function 1 of axis 1"),
        ("correction", np.r_[np.zeros(9), 2.0, np.zeros(6)], r"function 2 of axis 2"),
        ("correction", "none", "must be 16 numbers"),
    ],
)
def test_an_action_that_is_none_is_refused_with_its_place(of, action, said):
    with pytest.raises(ValueError, match=said):
        Rules(**(HOW | {"action": of})).decision(action)
