"""Commands that take a robot take its file: sweep, tune, train, measure, view, compare and imu."""

import shutil

import pytest
from tests.benchmarks.robot import shipped_files

from armside import assets
from armside.scripts.commands.imu import ImuOptions
from armside.scripts.commands.measure import MeasureCfg, gears
from armside.scripts.commands.train import TrainCfg
from armside.scripts.cutting.comparison import CompareCfg, cases_of
from armside.scripts.cutting.options import LaserCfg
from armside.scripts.cutting.part_options import CutCfg
from armside.scripts.jobs.grid import parse
from armside.scripts.jobs.resolved import key_of, resolved
from armside.scripts.shell.errors import InputError
from armside.scripts.studies.options import TuneCfg
from armside.scripts.viewers.sliders import posable
from armside.sim.robot.mjcf import ModelError

HERE = assets.LARGE_ROBOT_XML.parent


@pytest.fixture
def robot(tmp_path):
    """A copy of the two-link's files."""
    for name in ("two_link.toml", "two_link.xml"):
        shutil.copy(HERE / name, tmp_path / name)
    return tmp_path / "two_link.toml"


@pytest.fixture
def longer(robot):
    """Its robot file with a second link of 10 mm more than its model has."""
    text = robot.read_text(encoding="utf-8")
    robot.write_text(text.replace("a = 0.5", "a = 0.51"), encoding="utf-8")
    return robot


def test_a_sweep_knows_a_robot_by_the_content_of_its_files(robot, tmp_path):
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    for file in tmp_path.glob("two_link.*"):
        shutil.copy(file, moved)
    same, other = (key_of({"robot": str(f)}, 0) for f in (robot, moved / robot.name))
    assert same == other
    model = robot.with_suffix(".xml")
    model.write_text(model.read_text(encoding="utf-8") + "<!-- -->\n", encoding="utf-8")
    assert key_of({"robot": str(robot)}, 0) != other


def test_a_sweep_over_robots_has_the_poses_and_designs_of_each(robot):
    points = list(parse([f"robot=large,{robot}", "gamma=0.5/0.6,0.9", "delta=2"], 0))
    assert len(points) == 4  # one that six axes refuse is a row, as it is fine with two
    row = resolved(LaserCfg(robot=str(robot)))
    assert row["pose"] == "p1"
    assert row["position"] == [700.0, 300.0, 1000.0]


def test_a_relative_robot_file_is_the_same_in_a_worker_of_another_folder(robot, monkeypatch):
    monkeypatch.chdir(robot.parent)
    (point,) = parse(["robot=two_link.toml"], 0)
    assert point.options["robot"] == str(robot)


def test_a_study_is_of_the_content_of_a_robot_and_of_its_contours(robot):
    plain = TuneCfg().identity(0)
    assert not {"shape", "radius", "robot_content"} & plain.keys()
    cfg = TuneCfg(robot=str(robot), shape=("circle", "slot"), radius=(4.0, 20.0))
    assert cfg.identity(0)["radius"] == [4.0, 20.0]
    assert str(cfg.named(0).study).startswith("two_link-shared-tracker-")
    assert cfg.rules.shapes.radius == (0.004, 0.02)


def test_an_agent_is_trained_for_the_axes_of_a_robot_file(robot):
    assert TrainCfg(robot=str(robot), motors="each").rules.action_space.shape == (6,)
    with pytest.raises(ValueError, match="radius takes one value, or smallest and largest, got 3"):
        TrainCfg(radius=(1.0, 2.0, 3.0))


def test_the_viewer_and_the_gears_of_measured_data_are_those_of_a_robot_file(robot):
    assert posable(str(robot)).nu == 2
    import pyarrow as pa

    table = pa.table({"reference_1": [0.0], "reference_2": [0.0]})
    assert gears(MeasureCfg(robot=str(robot)), table).shape == (2,)


def test_each_refuses_a_file_whose_table_is_not_its_model(longer):
    import pyarrow as pa

    table = pa.table({"reference_1": [0.0], "reference_2": [0.0]})
    for use in (
        lambda: posable(str(longer)),
        lambda: gears(MeasureCfg(robot=str(longer)), table),
        lambda: TuneCfg(robot=str(longer)),
        lambda: TrainCfg(robot=str(longer)),
    ):
        with pytest.raises(ModelError, match="its tool is 10 mm and 0 deg off the D-H model"):
            use()
    with pytest.raises(InputError, match="its tool is 10 mm and 0 deg off the D-H model"):
        parse([f"robot={longer}"], 0)


def test_a_comparison_is_of_the_poses_of_its_robot(robot):
    cfg = CompareCfg(robot=str(robot), speeds=(40.0,))
    assert [case.cut.pose for case in cases_of(cfg, 0)] == ["p1", "p2", "p3"]
    with pytest.raises(ValueError, match="Unknown pose 'p9'"):
        CompareCfg(robot=str(robot), poses=("p9",))


def test_the_imu_experiment_refuses_a_robot_that_is_neither_known_nor_a_file(robot, longer):
    with pytest.raises(ValueError, match="Robots: large, irb1400, or a robot file"):
        ImuOptions(robot="ur10")
    with pytest.raises(ModelError, match="its tool is 10 mm and 0 deg off the D-H model"):
        ImuOptions(robot=str(longer)).experiment().model()


def test_a_part_is_cut_by_six_axes_and_others_are_told_what_cuts_contours(robot):
    with pytest.raises(ValueError, match=r"has 2: cut its contours one by one with armside laser"):
        CutCfg(robot=str(robot))
    assert CutCfg(robot=str(HERE / "kr16_like.toml")).plane == "base-xy"


def test_the_benchmark_of_runs_has_every_shipped_robot_once():
    names = [file.stem for file in shipped_files()]
    assert "two_link" in names
    assert not {"large_robot", "irb1400"} & set(names)
