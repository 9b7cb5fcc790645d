"""`armside robot`: numbers and verdicts of a model beside its D-H table."""

import json

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside import kinematics
from armside.scripts.cli import main
from armside.scripts.viewers.sliders import hold, posable
from armside.sim.cell import CELLS, LARGE_CELL
from armside.sim.robot.model import load_model
from armside.sim.robot.statics import Statics

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


def test_what_cannot_be_shown_is_refused_in_one_line(monkeypatch, tmp_path, bad_input):
    """For want of a display, of motors, or of the file."""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    box = "<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>"
    (tmp_path / "box.xml").write_text(box)
    bad_input("robot view", "no display")
    bad_input("robot view box.xml", "no joints motor_1")
    bad_input("robot view missing.xml", "missing.xml does not exist")


def said(capsys, *words, status=0):
    assert main(["robot", *words, "--json"]) == status
    captured = capsys.readouterr()
    return json.loads(captured.out), captured.err


def altered(tmp_path, change):
    """File of the large robot after `change` of its parsed file."""
    spec = mujoco.MjSpec.from_file(str(LARGE_CELL.xml))
    change(spec)
    spec.compile()
    file = tmp_path / "robot.xml"
    file.write_text(spec.to_xml(), encoding="utf-8")
    return str(file)


@pytest.mark.parametrize("name", CELLS)
def test_the_robots_of_the_project_pass_every_verdict(name, capsys):
    outcome, _ = said(capsys, "check", "--robot", name)
    assert outcome["status"] == "done"
    assert all(check["holds"] for check in outcome["checks"])
    assert len(outcome["checks"]) == 14
    assert [one["pose"] for one in outcome["poses"]] == ["p1", "p2", "p3"]
    model = load_model(CELLS[name].xml)
    assert outcome["mass"] == pytest.approx(model.mj.body_mass.sum())
    assert [one["gear"] for one in outcome["axes"]] == model.drives.gear.tolist()


def test_static_load_covers_the_torque_that_holds_the_arm_in_the_zero_pose(capsys):
    """The flexible arm's is within 1 % of the rigid one's, of which load is the greatest."""
    outcome, _ = said(capsys, "check", "--robot", "irb1400")
    model = load_model(CELLS["irb1400"].xml)
    held = Statics(model).equilibrium(np.zeros(6)).holding_torque
    limit = np.abs(model.drives.gear) * model.drives.torque_limit
    loads = np.array([one["holding"] for one in outcome["axes"]])
    assert (loads >= 0.99 * np.abs(held) / limit - 1e-6).all()


def shorter(spec):
    spec.body("tilt").pos = np.add(spec.body("tilt").pos, (-0.1, 0.0, 0.0))


def too_heavy(spec):
    spec.body("tool").mass *= 20.0


def too_slow_a_clock(spec):
    spec.option.timestep = 0.004


def narrow_stops(spec):
    spec.joint("motor_2").range = np.array([-0.5, 0.5])


FAULTS = {
    "site tool0 off the D-H model [um] is 1e+05": shorter,
    "torque of gravity over the drive's limit": too_heavy,
    "highest mode of the springs times time step": too_slow_a_clock,
    "hard stops beyond the controller's limits [deg]": narrow_stops,
}


@pytest.mark.parametrize("words", FAULTS)
def test_a_fault_is_a_verdict_that_fails_with_status_1(words, tmp_path, capsys):
    outcome, err = said(capsys, "check", altered(tmp_path, FAULTS[words]), status=1)
    assert outcome["status"] == "failed"
    assert words in err
    assert len(err.splitlines()) == 1
    assert (outcome["first_axis"] == 5) == ("axis 5" in err) == (FAULTS[words] is shorter)


def test_a_site_that_is_turned_is_off_by_its_angle(tmp_path, capsys):
    def turned(spec):
        by = Rotation.from_rotvec([0.0, 0.0, 0.02])
        own = Rotation.from_quat(spec.compile().site("tool0").quat, scalar_first=True)
        site = spec.site("tool0")
        site.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        site.quat = (own * by).as_quat(scalar_first=True)

    tool, _ = said(capsys, "check", altered(tmp_path, turned), status=1)[0]["agreement"]
    assert tool["rotation"] == pytest.approx(0.02, rel=1e-3)
    tool, _ = said(capsys, "check", altered(tmp_path, shorter), status=1)[0]["agreement"]
    assert tool["position"] == pytest.approx(0.1, rel=1e-3)


def turn(angle, axis):
    """Rotation by an angle [rad] about an axis of the frame, (4, 4)."""
    c, s, (i, j) = np.cos(angle), np.sin(angle), [(1, 2), (2, 0), (0, 1)][axis]
    T = np.eye(4)
    T[i, i], T[i, j], T[j, i], T[j, j] = c, -s, s, c
    return T


def test_show_prints_the_table_whose_product_is_the_zero_pose(capsys):
    outcome, _ = said(capsys, "show", "--robot", "irb1400")
    T = np.eye(4)
    for row in outcome["table"]:
        about_z, about_x = (turn(row[name], axis) for name, axis in (("theta", 2), ("alpha", 0)))
        along = np.eye(4)
        along[0, 3], along[2, 3] = row["a"], row["d"]
        T = T @ about_z @ along @ about_x
    own = kinematics.compile(CELLS["irb1400"].robot).pose(np.zeros(6))
    assert pytest.approx(own, abs=1e-12) == T
    assert outcome["table"][2]["motion"] == "-1 phi_2 +1 phi_3"


def test_show_never_takes_the_table_of_another_robot(tmp_path, capsys):
    assert main(["robot", "show", altered(tmp_path, shorter)]) == 2
    assert "is no LARGE_ROBOT: its tool is 100 mm" in capsys.readouterr().err


def test_tables_are_printed(capsys):
    assert main(["robot", "check"]) == 0
    printed = capsys.readouterr().out
    assert all(words in printed for words in ("Verdicts", "motors held", "axis", "tool0"))
