"""Poses and Jacobians of any frame in any axes, beside products of links and differences."""

import numpy as np
import pytest

from armside.kinematics import (
    IRB1400,
    IRB1400_IMU,
    Convention,
    compile,
    compile_frame_jacobian,
    compile_frame_pose,
)
from armside.kinematics.equations.forward_kinematics import jacobian, pose
from armside.kinematics.rigid import link_frames

ROUNDING, DIFFERENCES = 1e-12, 1e-8


def spin(R, R_change) -> np.ndarray:
    """omega of S(omega) = R' R^T."""
    S = R_change @ R.T
    return np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]]) / 2


@pytest.mark.parametrize("convention", Convention)
def test_every_frame_of_random_robots_in_every_axes(convention, random_robot, interpreted, central):
    robot = random_robot(np.random.default_rng(5), 3, convention)
    phi = np.random.default_rng(6).uniform(-1, 1, 3)
    frames = [np.eye(4), *link_frames(robot, phi)]
    for k, T in enumerate(frames):
        found = interpreted(pose(robot, k))(phi)
        np.testing.assert_allclose(found, T, rtol=0, atol=ROUNDING)
        change = central(lambda x, k=k: [np.eye(4), *link_frames(robot, x)][k], phi)
        v = change[:3, 3]
        omega = np.stack([spin(T[:3, :3], change[:3, :3, i]) for i in range(3)], axis=1)
        for axes, other in enumerate(frames):
            R = other[:3, :3].T
            J = interpreted(jacobian(robot, k, axes))(phi)
            expected = np.concatenate([R @ v, R @ omega])
            np.testing.assert_allclose(J, expected, rtol=0, atol=DIFFERENCES)


def test_the_last_frame_in_base_axes_is_the_tool_and_its_coupling_is_kept():
    phi = np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])
    J = compile_frame_jacobian(IRB1400, 6)(phi)
    np.testing.assert_allclose(J, compile(IRB1400).jacobian(phi), rtol=0, atol=ROUNDING)
    T = compile_frame_pose(IRB1400_IMU, 8)(phi)
    np.testing.assert_allclose(T, compile(IRB1400_IMU).pose(phi), rtol=0, atol=ROUNDING)
    elbow = compile_frame_jacobian(IRB1400, 3, 3)(np.array([phi, phi]))
    assert elbow.shape == (2, 6, 6)
    assert not elbow[:, :, 3:].any()


@pytest.mark.parametrize("frame", [-1, 7, 1.0, True])
def test_other_frames_are_refused(frame):
    with pytest.raises(ValueError, match="frame must be 0 to 6 for IRB1400, got"):
        compile_frame_jacobian(IRB1400, frame)
