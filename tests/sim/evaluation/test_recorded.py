"""Turns of recorded data check themselves."""

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from armside.sim.evaluation.recorded import (
    CircleTurn,
    measure_table,
    notes_of_signals,
    notes_of_table,
)
from armside.sim.laser import Cut, prepare
from armside.sim.laser.loop import first_run
from armside.sim.notes import Cause
from armside.sim.records.signals import RecordedRun, Signals


@pytest.mark.parametrize(("start", "end"), [(1.0, 0.0), (1.0, 1.0), (np.nan, 1.0)])
def test_a_turn_that_ends_before_it_starts_is_refused(start, end):
    with pytest.raises(ValueError, match="start must be before end"):
        CircleTurn(radius=0.005, start=start, end=end)


GEAR = np.array([100.0, -50.0])
RADIUS = 0.005


@pytest.fixture
def table():
    """Two iterations of 100 log samples; the tracker sees a circle that leans out of its plane."""
    t = np.arange(100) * 0.01
    angle = 2 * np.pi * t
    columns = {"k": [], "time": [], "tracker_x": [], "tracker_y": [], "tracker_z": []}
    columns |= {f"{kind}_{i}": [] for kind in ("reference", "motor_angle") for i in (1, 2)}
    for k in (0, 1):
        error = (1e-3 * np.sin(angle), 2e-3 * np.cos(angle))
        columns["k"] += [k] * 100
        columns["time"] += t.tolist()
        for i, e in enumerate(error, 1):
            columns[f"reference_{i}"] += np.sin(angle).tolist()
            columns[f"motor_angle_{i}"] += (np.sin(angle) - e / (k + 1)).tolist()
        radius = RADIUS + 1e-4 / (k + 1) * np.sin(3 * angle)
        columns["tracker_x"] += (1.0 + radius * np.cos(angle)).tolist()
        columns["tracker_y"] += (2.0 + radius * np.sin(angle)).tolist()
        columns["tracker_z"] += (3.0 + 0.5 * radius * np.cos(angle)).tolist()
    return pa.table(columns)


def test_errors_are_those_of_the_motor_shafts(table):
    first, second = measure_table(table, GEAR, None)
    assert first.motor_inf == pytest.approx([0.1, 0.1], rel=1e-3)
    assert first.motor_two == pytest.approx([0.1 * np.sqrt(50)] * 2)
    assert second.motor_two == pytest.approx(0.5 * first.motor_two)
    assert np.isnan([first.arm_rms, second.arm_maxdev]).all()


def test_the_circle_is_that_of_the_plane_given(table):
    """Seen along z the leaning circle is round; in its own best plane it is an ellipse."""
    first, second = measure_table(table, GEAR, CircleTurn(radius=RADIUS))
    assert first.arm_rms == pytest.approx(1e-4 / np.sqrt(2), rel=1e-6)
    assert first.arm_maxdev == pytest.approx(1e-4, rel=0.01)
    assert second.arm_rms == pytest.approx(0.5 * first.arm_rms)


def test_samples_outside_of_the_turn_do_not_count(table):
    """A sample at its end is not part of it."""
    lost = table.to_pydict()
    for name in ("tracker_x", "tracker_y"):
        lost[name][99] = lost[name][199] = 7.0
    other = pa.table(lost)
    start, end = CircleTurn(radius=RADIUS, end=0.99), CircleTurn(radius=RADIUS, start=0.01)
    without = measure_table(other, GEAR, start)[0]
    assert without.arm_rms == pytest.approx(1e-4 / np.sqrt(2), rel=0.05)
    assert measure_table(other, GEAR, end)[0].arm_rms > 1e-2


@pytest.fixture(scope="module")
def recorded():
    experiment = prepare(Cut(speed=0.1), seed=0)
    return experiment, first_run(experiment)


def signals(experiment, *runs):
    path = experiment.motion
    return Signals(runs=runs, config={}, seed=0, version="", path=path, gear=np.ones(6))


def test_a_stored_run_says_that_its_speed_was_lowered(recorded):
    experiment, run = recorded
    (note,) = notes_of_signals(signals(experiment, RecordedRun(k=0, recording=run.recording)))
    assert note.cause is Cause.SPEED
    assert "from 100 to 80.62 mm/s: the acceleration limit across the path" in note.line


def test_limits_of_several_runs_are_one_line(recorded):
    experiment, run = recorded
    hit = replace(run.recording, limits_hit=(("torque", 2, 0.4),))
    lost = replace(run.tracker, valid=np.zeros(len(run.tracker.time), dtype=bool))
    runs = [RecordedRun(k=k, recording=hit, tracker=lost) for k in (0, 1)]
    _, saturated, beam = notes_of_signals(signals(experiment, *runs))
    assert saturated.line == "drives saturate: torque limit of axis 2 (k = 0 to 1)"
    assert (
        beam.line == "the laser tracker lost its beam: no error of the tool is known (k = 0 to 1)"
    )


def test_lost_samples_of_a_table_are_counted():
    table = pa.table({"tracker_valid": [True, False, None, False]})
    (note,) = notes_of_table(table)
    assert "lost its beam in 2 samples" in note.text
    assert notes_of_table(pa.table({"tracker_valid": [1, 1, None]})) == []
    assert notes_of_table(pa.table({"time": [0.0]})) == []
