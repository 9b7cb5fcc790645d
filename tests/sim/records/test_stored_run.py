"""A run on disk is whole: it is read, drawn and measured from its own files, without planning."""

import json
import shutil
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
import ruckig

from armside.scripts import cli
from armside.scripts.commands import measure
from armside.sim.cell import TOOL_QUATERNION
from armside.sim.evaluation.recorded import measure_signals
from armside.sim.laser import experiment, specification
from armside.sim.motion import tool_motion
from armside.sim.motion.contour import Circle, hexagon, slot
from armside.sim.motion.path import CuttingPath, Plane
from armside.sim.recordings.read import read_run_motion
from armside.sim.records import read_run
from armside.sim.records.files import InputError
from armside.sim.records.programmed_path import from_json, to_json
from armside.sim.replay import film
from armside.sim.replay.run_scene import read_replay

CUTS = {
    "circle": "laser --iterations 1",
    "square": "laser --iterations 0 --shape square --lead-in spiral --plane tool --robot irb1400",
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for name, line in CUTS.items():
        assert cli.main([*line.split(), "--quiet", "--out", str(folder / name)]) == 0
    return folder


@pytest.fixture
def no_planner(monkeypatch):
    """Replaces everything that plans a motion or builds an experiment by an error."""

    def refuse(*_, **__):
        raise AssertionError("a stored run must not be planned again")

    for module, name in (
        (tool_motion, "cut"),
        (specification, "plan_cut"),
        (experiment, "prepare"),
        (measure, "cell_model"),
        (ruckig, "Ruckig"),
    ):
        monkeypatch.setattr(module, name, refuse)


@pytest.mark.parametrize("name", CUTS)
def test_measures_of_a_stored_run_are_those_of_its_summary_bit_for_bit(folders, name, no_planner):
    run = read_run(folders / name)
    for measured, row in zip(measure_signals(run.signals), run.summary["iterations"], strict=True):
        assert measured.motor_inf.tolist() == row["motor_inf"]
        assert measured.motor_two.tolist() == row["motor_two"]
        assert (measured.arm_rms, measured.arm_maxdev) == (row["arm_rms"], row["arm_maxdev"])


@pytest.mark.parametrize("name", CUTS)
def test_the_commands_work_without_a_planner(folders, name, no_planner, tmp_path, capsys):
    out = tmp_path / "replay.rrd"
    assert cli.main(["replay", str(folders / name), "--save", str(out), "--quiet"]) == 0
    assert out.stat().st_size > 1e5
    assert cli.main(["measure", str(folders / name / "signals.parquet"), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["iterations"]
    assert rows[0]["arm_rms"] == read_run(folders / name).summary["iterations"][0]["arm_rms"]


def test_a_film_needs_only_the_run(folders, no_planner):
    shots = film.stored_shots(read_run(folders / "circle"))
    assert len(shots.runs) == len(shots.contours) == 2
    assert shots.mj.camera("whole").id >= 0  # on its floor


def test_the_robot_drawn_is_that_of_the_run_and_not_todays(folders, tmp_path):
    old = shutil.copytree(folders / "circle", tmp_path / "old")
    text = (old / "robot.xml").read_text()
    assert 'name="disc"' in text
    (old / "robot.xml").write_text(text.replace('name="disc"', 'name="another_disc"'))
    assert film.stored_shots(read_run(old)).mj.body("another_disc").id > 0


@pytest.mark.parametrize("curve", [Circle(0.005), hexagon(0.02, 0.003), slot(0.03, 0.01)])
@pytest.mark.parametrize("spiral", [None, 0.6])
def test_a_programmed_path_comes_back_bit_for_bit(curve, spiral):
    plane = Plane.perpendicular_to([0.1, 0.2, 1.0], [1.3, 0.1, 1.6])
    lead = 0.25 if spiral else 0.1
    path = CuttingPath.around(curve, plane, lead=lead, spiral=spiral)
    motion = tool_motion.cut(path, TOOL_QUATERNION, 0.09)
    back = from_json(json.loads(json.dumps(to_json(motion))))
    for name in ("time", "position", "quaternion", "arc_length", "on_contour"):
        assert getattr(back, name).tobytes() == getattr(motion, name).tobytes(), name
    assert np.array_equal(back.plane.axes, motion.plane.axes)
    assert (back.contour_time, back.limits_hit) == (motion.contour_time, motion.limits_hit)
    assert (back.programmed_speed, back.reached_speed) == (0.09, motion.reached_speed)
    time = np.linspace(0.0, motion.time[-1], 997)
    assert back.position_at(time).tobytes() == motion.position_at(time).tobytes()


def test_a_contour_that_cannot_be_stored_is_named():
    class Bean:
        def __getattr__(self, name):
            return getattr(Circle(0.005), name)

    bean: Any = Bean()
    path = CuttingPath.around(bean, Plane(np.array([1.3, 0.0, 1.6])))
    with pytest.raises(ValueError, match="Bean cannot be stored; Circle, ArcsAndLines can"):
        to_json(tool_motion.cut(path, TOOL_QUATERNION, 0.04))


def test_a_run_is_read_with_its_path(folders):
    run = read_run(str(folders / "circle"))
    assert run.experiment == "laser"
    assert run.path.path.curve == Circle(0.005)
    assert run.path.time.shape == run.signals.runs[0].recording.time.shape
    assert run.signals.gear is not None
    assert run.signals.gear.shape == (6,)


def test_a_run_without_path_is_read_but_neither_replayed_nor_measured(folders, tmp_path, capsys):
    old = shutil.copytree(folders / "circle", tmp_path / "old")
    file = old / "signals.parquet"
    table = pq.read_table(file)
    kept = {key: text for key, text in table.schema.metadata.items() if key != b"armside.path"}
    pq.write_table(table.replace_schema_metadata(kept), file)
    assert len(read_run(old).signals.runs) == 2
    with pytest.raises(InputError, match=r"no programmed path.* run it again"):
        read_replay([read_run(old)])
    assert cli.main(["measure", str(file)]) == 2
    assert "run it again" in capsys.readouterr().err
    (old / "robot.xml").unlink()
    with pytest.raises(InputError, match=r"has no robot\.xml"):
        _ = read_run(old).robot


def test_the_recording_of_a_run_is_its_first_iteration_by_its_sensors(folders):
    run, motion = read_run(folders / "circle").signals.runs[0], read_run_motion(folders / "circle")
    assert run.k == 0
    np.testing.assert_array_equal(motion.encoders.values, run.recording.motor_angle)
    np.testing.assert_array_equal(motion.encoders.time, run.recording.time)
