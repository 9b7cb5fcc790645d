"""Named poses of a cell: reach, limits and singularities."""

from dataclasses import replace

import numpy as np
import pytest

from armside import kinematics
from armside.kinematics.rotation import to_quaternion
from armside.sim.cell import IRB1400_CELL, ToolPose
from armside.sim.evaluation.robot_examination import LEAST_DEXTERITY, checks_of, named_poses

P1 = IRB1400_CELL.poses["p1"]


def found(pose, *, free=False):
    return named_poses(replace(IRB1400_CELL, poses={"p1": P1, "own": pose}, free_rotation=free))


def test_a_pose_is_reached_by_its_motor_angles():
    for name, one in zip("123", named_poses(IRB1400_CELL), strict=True):
        assert one.motor_angle is not None
        T = kinematics.compile(IRB1400_CELL.robot).pose(one.motor_angle)
        np.testing.assert_allclose(T[:3, 3], IRB1400_CELL.poses[f"p{name}"].position, atol=1e-9)
    assert all(check.holds for check in checks_of(named_poses(IRB1400_CELL)))


def test_a_pose_out_of_reach_is_named_with_the_distance():
    missed, _ = checks_of(found(ToolPose((3.0, 0.0, 1.0), P1.quaternion)))
    assert not missed.holds
    assert "own" in missed.statement
    assert "reach" in missed.statement


@pytest.mark.parametrize("free", [True, False])
def test_the_pose_named_as_the_nearest_reachable_one_can_be_cut_at(free):
    """With a free orientation the nearest point is that of the stretched arm, a singularity."""
    asked = ToolPose((3.0, 0.0, 1.0), P1.quaternion)
    (_, missed) = found(asked, free=free)
    assert missed.nearest is not None
    off = np.linalg.norm(np.subtract(missed.nearest.pose.position, asked.position))
    assert missed.nearest.distance == pytest.approx(off, abs=1e-9)
    reach = 1.6  # [m], of the arm from its base: the tool at full stretch, forwards
    assert 3.0 - reach < missed.nearest.distance < 1.15 * (3.0 - reach)
    shown = tuple(round(x, 4) for x in missed.nearest.pose.position)
    assert ", ".join(map(str, shown)) in str(missed.nearest)
    w, a, b, c = (round(x, 4) for x in missed.nearest.pose.quaternion)
    rounded = ToolPose(shown, (w, a, b, c))
    assert all(check.holds for check in checks_of(found(rounded, free=free)))


def test_a_pose_at_a_singularity_is_named():
    straight = kinematics.compile(IRB1400_CELL.robot).pose(np.array([0.1, 0.2, 0.1, 0.4, 0.0, 0.2]))
    w, a, b, c = to_quaternion(straight[:3, :3])
    x, y, z = straight[:3, 3]
    _, singular = checks_of(found(ToolPose((x, y, z), (w, a, b, c))))
    assert not singular.holds
    assert singular.statement.endswith("pose own")
    assert singular.ours == pytest.approx(0.0, abs=0.1 * LEAST_DEXTERITY)


def test_a_robot_without_poses_has_none_to_miss():
    (missed,) = checks_of([])
    assert missed.holds
