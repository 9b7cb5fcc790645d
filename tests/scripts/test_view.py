"""`armside robot view`: a robot that stays where its sliders are, or a word of the display."""

import mujoco
import numpy as np
import pytest

from armside.scripts import cli
from armside.scripts.viewers.robot import hold, posable

SECOND = 2000
"""Steps."""


@pytest.mark.parametrize("robot", ["large", "irb1400"])
def test_sliders_hold_the_robot_and_move_it(robot):
    mj = posable(robot)
    data = mujoco.MjData(mj)
    hold(mj, data)
    mujoco.mj_step(mj, data, SECOND)
    angle = data.qpos[mj.jnt_qposadr[mj.actuator_trnid[:, 0]]]
    np.testing.assert_allclose(angle, 0.0, atol=0.01)  # sags by gravity over stiffness
    data.ctrl[0] = 0.5
    mujoco.mj_step(mj, data, SECOND)
    assert data.joint("motor_1").qpos[0] == pytest.approx(0.5, abs=1e-3)


def test_there_is_a_slider_for_each_motor_within_its_limits():
    mj = posable("large")
    assert [mj.actuator(i).name for i in range(mj.nu)] == [f"axis_{i}" for i in range(1, 7)]
    np.testing.assert_array_equal(mj.actuator_ctrlrange, mj.jnt_range[mj.actuator_trnid[:, 0]])


def test_without_a_display_it_says_so_in_one_line(monkeypatch, capsys):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert cli.main(["robot", "view"]) == 2
    _, err = capsys.readouterr()
    assert "no display" in err
    assert err.count("\n") == 1


def test_a_model_without_motors_is_refused(tmp_path, capsys):
    file = tmp_path / "box.xml"
    file.write_text("<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>")
    assert cli.main(["robot", "view", str(file)]) == 2
    assert "no joints motor_1" in capsys.readouterr().err
    assert cli.main(["robot", "view", "missing.xml"]) == 2
    assert "missing.xml does not exist" in capsys.readouterr().err
