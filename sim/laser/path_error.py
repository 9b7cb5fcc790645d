"""Error of an estimated tool path against the ground truth, and the path of rigid kinematics."""

import numpy as np

from armside import kinematics
from armside.arrays import Array

from ..estimation.relative_path import relative_to_start
from .experiment import Pass


def rigid_path(run: Pass, robot: kinematics.Robot = kinematics.LARGE_ROBOT) -> Array:
    """(N, 6): path of the tool by rigid kinematics of the measured motor angles, from rest."""
    compiled = kinematics.compile(robot)
    angle = np.ascontiguousarray(run.recording.motor_angle)
    return relative_to_start(compiled.pose(angle)[:, :3, 3])


def path_error(path: Array, run: Pass) -> float:
    """RMS distance [m] of a path (N, 6) from the ground truth, at the same instants, from rest."""
    truth = run.recording.truth
    every = round(float(run.recording.time[1] / truth.time[1]))
    true = relative_to_start(truth.tool_position[::every])
    return float(np.sqrt(np.square((path - true)[:, :3]).sum(axis=1).mean()))
