"""Notes of recorded data are those of the run that was recorded."""

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from armside.sim.evaluation.recorded import notes_of_signals, notes_of_table
from armside.sim.laser import Cut, prepare
from armside.sim.laser.learning import first_run
from armside.sim.notes import Cause
from armside.sim.records.signals import RecordedRun, Signals


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
