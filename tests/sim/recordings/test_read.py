"""Which folder is a recording of motion."""

import pytest

from armside.sim.recordings.read import is_motion


@pytest.mark.parametrize("left_out", [None, "signals.parquet", "summary.json"])
def test_a_run_is_a_recording_by_its_signals_and_its_summary(tmp_path, left_out):
    for name in {"signals.parquet", "summary.json"} - {left_out}:
        (tmp_path / name).touch()
    assert is_motion(tmp_path) == (left_out is None)
