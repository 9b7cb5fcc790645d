"""Design variables and the actions that stand for them."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.sim.laser.design import THESIS, Design
from armside.sim.tuning.action import VARIABLES, Motors, action_of, design_of
from armside.sim.tuning.env import IlcTuningEnv
from armside.sim.tuning.rules import Rules

ROUNDING = 1e-6
"""Relative, of a float32 action."""


def test_the_table_of_the_env_says_what_the_variables_are():
    rows = re.findall(
        r"^ +\| (\w+) \| ([\d.]+) \| ([\d.]+) \| .* \| ([\w ]+) \|$",
        IlcTuningEnv.__doc__ or "",
        re.M,
    )
    assert rows == [(v.name, f"{v.low:g}", f"{v.high:g}", v.scale.value) for v in VARIABLES]


@pytest.mark.parametrize(("motors", "size"), [("shared", 3), ("each", 18)])
def test_the_action_space_has_the_documented_shape(motors, size):
    space = Rules(motors=motors).action_space
    assert space.shape == (size,)
    assert space.dtype == np.float32
    assert (space.low == -1).all()
    assert (space.high == 1).all()


@pytest.mark.parametrize("motors", list(Motors))
def test_the_ends_of_an_action_are_the_ends_of_the_ranges(motors):
    n = 3 * motors.count()
    for end, name in ((-1.0, "low"), (1.0, "high")):
        made = design_of(np.full(n, end), motors)
        for variable in VARIABLES:
            assert getattr(made, variable.name) == (getattr(variable, name),) * motors.count()


@pytest.mark.parametrize("motors", list(Motors))
def test_the_thesis_design_is_an_action(motors):
    made = design_of(action_of(THESIS, motors), motors).arrays(6)
    assert made["gamma"] == pytest.approx(np.full(6, 0.9), rel=ROUNDING)
    assert made["delta"].tolist() == [3.0] * 6
    assert made["cutoff"] == pytest.approx(np.full(6, 10.0), rel=ROUNDING)


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


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ([0.0, 1.1, 0.0], r"\[-1, 1\], got 1.1 at index 1 \(delta\)"),
        ([0.0, 0.0, -np.inf], r"got -inf at index 2 \(cutoff\)"),
        ([np.nan, 0.0, 0.0], r"got nan at index 0 \(gamma\)"),
        ([0.0, 0.0], r"shape \(3,\), got \(2,\)"),
    ],
)
def test_an_action_that_is_none_is_refused_with_its_place(action, message):
    with pytest.raises(ValueError, match=message):
        design_of(action, Motors.SHARED)


def test_a_design_outside_of_the_ranges_is_no_action():
    with pytest.raises(ValueError, match=r"gamma must be in \[0.1, 1.5\]"):
        action_of(Design(gamma=(2.0,), delta=(3,), cutoff=(10.0,)), Motors.SHARED)
