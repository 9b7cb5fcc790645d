"""`armside verify robots`: a small slice of it, and verdicts that fail by one run alone."""

import pytest

from armside.scripts.verifications import robots
from armside.sim.robot_file.find import find_cell

from .verdicts import failing


def test_one_robot_at_one_pose_keeps_every_statement(monkeypatch):
    monkeypatch.setattr(robots, "ROBOTS", {"SCARA": robots.ROBOTS["SCARA"]})
    monkeypatch.setattr(robots, "POSES", ("p1",))
    table = robots.robots([7])
    assert not failing(table)
    assert len(table.verdicts) == 4
    assert table.rows[0][:2] == (7, "SCARA")


@pytest.mark.parametrize("measure", ["_motor", "_tracker"])
def test_one_run_above_its_bar_fails_the_statement_alone(measure, monkeypatch):
    def left(task, pose, seed, said=None, *, bad=False):
        return 0.101 if bad and (task.file, pose, seed) == ("scara", "p2", 1) else 0.1

    monkeypatch.setattr(robots, "_checked", lambda: iter(()))
    monkeypatch.setattr(robots, "_motor", left)
    monkeypatch.setattr(robots, "_tracker", left)
    assert not failing(robots.robots(range(2)))
    monkeypatch.setattr(robots, measure, lambda *given: left(*given, bad=True))
    assert len(failing(robots.robots(range(2)))) == 1


def test_no_robot_is_judged_where_or_on_whom_its_design_was_found():
    for task in robots.ROBOTS.values():
        cell = find_cell(robots.file_of(task))
        assert cell.learning is not None
        judged = [cell.poses[name] for name in robots.POSES]
        assert all(task.training.position != pose.position for pose in judged)
    assert robots.TRAINING_SEED >= 100
