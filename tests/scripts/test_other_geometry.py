"""A robot model of another geometry is refused by everything that takes or loads one."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from armside.sim.cell import CELLS, LARGE_CELL
from armside.sim.imu.imu_specification import RestExperiment, RobotSetup
from armside.sim.laser import Cut, prepare
from armside.sim.robot.mjcf import ModelError
from armside.sim.tuning.rules import Rules
from armside.sim.twin.twin import design_of

SAID = "is no LARGE_ROBOT: its tool is 100 mm and 0 deg off the D-H model"


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """MJCF of the large robot with a forearm 100 mm shorter."""
    spec = mujoco.MjSpec.from_file(str(LARGE_CELL.xml))
    spec.body("tilt").pos = np.add(spec.body("tilt").pos, (-0.1, 0.0, 0.0))
    spec.compile()
    file = tmp_path_factory.mktemp("models") / "short.xml"
    file.write_text(spec.to_xml(), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    "command",
    [
        "laser --model {}",
        "laser --model {} --measure tracker --iterations 0",
        "identify --model {}",
        "sweep model={} gamma=0.5,0.9 seed=0:2",
    ],
)
def test_every_command_with_a_model_refuses_it_in_one_line(short, command, bad_input):
    line = bad_input(command.format(short), f"{short}: the model {SAID}")
    assert line.endswith("axis 5 is the first that moves it otherwise\n")


LOADED = {
    "cut": lambda: prepare(Cut()),
    "cut of a cell of one's own": lambda: prepare(Cut(robot=CELLS["large"])),
    "imu": RobotSetup(robot="large").model,
    "env": Rules,
    "twin": lambda: design_of("large", None),
}


@pytest.mark.parametrize("what", LOADED)
def test_a_cell_whose_model_is_not_its_table_is_refused(short, what, monkeypatch):
    monkeypatch.setitem(CELLS, "large", replace(LARGE_CELL, xml=short))
    with pytest.raises(ModelError, match=SAID):
        LOADED[what]()


def test_the_brakes_of_a_rest_experiment_are_of_a_checked_robot(short, monkeypatch):
    monkeypatch.setitem(CELLS, "irb1400", replace(CELLS["irb1400"], xml=short))
    with pytest.raises(ModelError, match="is no IRB1400"):
        RestExperiment().model()


def test_the_robots_own_file_as_a_model_gives_its_results():
    own, given = (prepare(Cut(model=model)).loaded for model in (None, LARGE_CELL.xml))
    assert np.array_equal(own.controls, given.controls)
