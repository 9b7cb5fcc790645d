"""A cut of an arm with two axes, which learns in its plane."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from armside import assets
from armside.sim.cell import ToolPose
from armside.sim.laser import Cut, learn, prepare
from armside.sim.laser.design import default_design
from armside.sim.laser.measures import _on_nominal
from armside.sim.records.signals import RecordedRun, read_signals, write_signals

CUT = Cut(robot=str(assets.LARGE_ROBOT_XML.with_name("two_link.toml")))
LEFT = 0.10
"""Of the error of k = 0, after five updates."""


@pytest.fixture(scope="module")
def by_motors():
    return list(learn(CUT, seed=0))


def test_a_cut_is_learned_by_five_updates_where_no_number_is_given(by_motors):
    assert [iteration.k for iteration in by_motors] == [0, 1, 2, 3, 4, 5]


def test_two_motors_learn_to_a_tenth_of_their_first_error(by_motors):
    first, last = (np.abs(by_motors[k].motor_error).max(axis=0) for k in (0, -1))
    assert first.shape == (2,)
    assert (last <= LEFT * first).all()


def test_the_tool_learns_in_the_plane_from_the_tracker():
    first, *_, last = learn(CUT, measure="tracker", seed=0)
    assert last.tool_true.rms <= LEFT * first.tool_true.rms
    height = last.run.recording.truth.tool_position[:, 2]
    assert np.abs(height - 1.0).max() < 1e-12
    assert last.correction.shape[1] == 2


def test_columns_of_the_signals_follow_the_axes(by_motors, tmp_path):
    run = by_motors[-1].run
    file = tmp_path / "signals.parquet"
    write_signals(file, [RecordedRun(k=5, recording=run.recording)], config={}, seed=0)
    again = read_signals(file).runs[0].recording
    assert np.array_equal(again.reference, run.recording.reference)
    assert np.array_equal(again.motor_torque, run.recording.motor_torque)


def test_a_place_beyond_the_reach_is_refused_with_what_remains():
    far = ToolPose((1.2, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match=r"no configuration of two-link found: .* mm"):
        learn(replace(CUT, pose=far))


def test_a_loop_that_is_gone_on_from_ends_after_as_many_updates_as_are_asked_for():
    """Also beyond 256, from where on equal numbers are not one object."""
    (first,) = learn(CUT, iterations=0, seed=0)
    later = replace(first.state, loop=replace(first.state.loop, k=300))
    iterations = islice(learn(CUT, iterations=2, start=later, seed=0), 5)
    assert [iteration.k for iteration in iterations] == [0, 301, 302]


def test_a_simulated_error_is_the_target_less_what_the_nominal_motors_do():
    """It grows by what is added to the target alone, and is that of a servo: below 0.1 rad."""
    experiment, law = prepare(CUT, seed=0), default_design(CUT.cell).law
    reference = experiment.loaded.reference
    zero = np.zeros_like(reference)
    error, shifted = (
        _on_nominal(experiment, reference + shift, law).simulation(zero) for shift in (0.0, 0.25)
    )
    assert 0.0 < np.abs(error).max() < 0.1
    np.testing.assert_allclose(shifted - error, 0.25, atol=1e-12)
