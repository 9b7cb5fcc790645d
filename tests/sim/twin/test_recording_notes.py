"""Notes of recorded cuts are those of the run that a twin is commissioned from."""

from dataclasses import replace

import pyarrow as pa
import pyarrow.parquet as pq

from armside.sim.laser import Cut, prepare
from armside.sim.laser.learning import first_run
from armside.sim.notes import Cause
from armside.sim.records.signals import RecordedRun, write_signals
from armside.sim.twin.recordings import notes_of_first_run


def test_notes_of_a_run_are_those_of_its_first_iteration(tmp_path):
    experiment = prepare(Cut(speed=0.1), seed=3)
    log = first_run(experiment).recording
    hit = replace(log, limits_hit=(("torque", 2, 0.4),))
    runs = [RecordedRun(k=k, recording=recording) for k, recording in enumerate((log, hit))]
    file = tmp_path / "ours.parquet"
    write_signals(file, runs, config={}, seed=3, motion=experiment.motion)
    (note,) = notes_of_first_run(file)
    assert note.cause is Cause.SPEED


def test_lost_samples_of_a_table_are_noted(tmp_path):
    lost = pa.table({"time": [0.0, 0.004], "tracker_valid": [True, False]})
    pq.write_table(lost, tmp_path / "mine.parquet")
    (note,) = notes_of_first_run(tmp_path / "mine.parquet")
    assert note.cause is Cause.BEAM


def test_a_run_without_its_truth_is_noted_as_any_other_table(tmp_path):
    experiment = prepare(Cut(), seed=3)
    log = first_run(experiment).recording
    file = tmp_path / "ours.parquet"
    write_signals(file, [RecordedRun(k=0, recording=log)], config={}, seed=3)
    table = pq.read_table(file)
    truth = [name for name in table.column_names if name.startswith("true_")]
    for taken_out in (["k"], truth):
        pq.write_table(table.drop_columns(taken_out), file)
        assert notes_of_first_run(file) == []
