"""Torques of weights about joints, by hand."""

import numpy as np
import pytest

from armside.kinematics import Link, Robot
from armside.kinematics.calibration.joint_errors import G, gravity_torques

ARM = Robot((Link(alpha=np.pi / 2), Link(a=0.5), Link(a=0.3)), name="upright planar arm")
"""A vertical axis, and two horizontal ones whose positive angles lift the arm."""


@pytest.mark.parametrize("heading", [0.0, 1.0])
def test_a_weight_turns_an_axis_down_by_its_horizontal_distance(heading):
    q = np.array([[heading, 0.0, 0.0], [heading, np.pi / 3, 0.0], [heading, np.pi / 3, 0.2]])
    found = gravity_torques(ARM, q, [0, 1, 2])
    elbow, tool = 0.5 * np.cos(q[:, 1]), 0.3 * np.cos(q[:, 1] + q[:, 2])
    about_shoulder = np.stack([0.0 * elbow, -G * elbow, -G * (elbow + tool)], axis=1)
    # axis 1: frames 2, 3 and tool; axis 2: frame 3 and tool; axis 3: tool
    expected = np.column_stack([np.zeros((3, 3)), about_shoulder[:, 1:], -G * tool])
    np.testing.assert_allclose(found, expected, atol=1e-12)
