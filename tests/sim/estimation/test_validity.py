"""Trust in an estimate, second by second."""

import numpy as np
import pytest

from armside.arrays import Array
from armside.sim.estimation.estimator import FADE, OF_LONG, OF_SHORT, Limits, ToolEstimate, validity

TIME: Array = np.arange(1500, dtype=np.float64) * 0.004
INSTANTS: Array = np.arange(600, dtype=np.float64) * 0.01


def estimate(innovation: float = 1.0, shift: float = 0.0, at: float = 3.2) -> ToolEstimate:
    """Six seconds with white innovations; one second from `at` on with others."""
    e = np.random.default_rng(5).normal(size=(600, 6))
    e[(np.floor(at) <= INSTANTS) & (np.floor(at) + 1.0 > INSTANTS), 2] *= innovation
    moved = np.zeros((1500, 3))
    moved[(at <= TIME) & (at + 0.1 > TIME), 1] = shift
    return ToolEstimate(np.zeros((1500, 6)), moved, e, INSTANTS)


def test_white_innovations_are_trusted_everywhere():
    found = validity(estimate(), TIME)
    assert (found.weight == 1.0).all()
    assert found.text == ""


@pytest.mark.parametrize(
    "case",
    [estimate(innovation=1.5 * OF_LONG.innovation), estimate(shift=1.1 * OF_LONG.shift)],
    ids=["innovations", "shift"],
)
def test_what_cannot_be_explained_is_not_learned_from_there_alone(case: ToolEstimate):
    found = validity(case, TIME)
    there = (TIME >= 3.0) & (TIME < 4.0)
    assert found.weight[there].max() < 1e-9
    far = (TIME < 3.0 - 3.0 * FADE) | (TIME > 4.0 + 3.0 * FADE)
    assert found.weight[far] == pytest.approx(1.0)
    assert "in the second that begins at 3 s" in found.text


def test_a_little_more_than_white_is_trusted():
    near = estimate(innovation=0.8 * OF_LONG.innovation, shift=0.9 * OF_LONG.shift)
    assert (validity(near, TIME).weight == 1.0).all()


def test_a_path_that_is_not_finite_is_not_trusted():
    assert validity(estimate(shift=float("nan")), TIME).weight[825] < 1e-9


def test_seconds_without_readings_rest_on_motors_and_springs():
    lost = estimate()
    lost.innovation[200:300] = np.nan
    assert (validity(lost, TIME).weight == 1.0).all()


@pytest.mark.parametrize("limits", [OF_LONG, OF_SHORT])
def test_a_run_of_a_few_seconds_is_trusted_longer_than_a_long_one(limits: Limits):
    """Innovations of 20 and 1 mm, which sound short cuts have, and long ones that go wrong."""
    seconds = 2.0 if limits is OF_SHORT else 6.0
    time, instants = TIME[seconds > TIME], INSTANTS[seconds > INSTANTS]
    e = 20.0 * np.random.default_rng(7).normal(size=(len(instants), 6))
    moved = np.full((len(time), 3), 1e-3 / np.sqrt(3.0))
    found = validity(ToolEstimate(np.zeros((len(time), 6)), moved, e, instants), time)
    assert (found.weight == 1.0).all() == (limits is OF_SHORT)
    assert (found.weight < 1e-9).all() == (limits is OF_LONG)
