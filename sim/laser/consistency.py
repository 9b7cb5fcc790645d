"""Consistency of the arm's estimate with the ground truth: NIS and NEES of one run."""

from collections.abc import Callable
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import bounds, normalised_squared
from armside.ilc.estimation.prediction_error import ParameterEstimate

from ..estimation.arm_estimator import ArmEstimator
from ..estimation.arm_identification import Run
from ..estimation.relative_path import relative_to_start
from ..estimation.tool_covariance import tool_covariance
from ..robot.model import RobotModel
from ..robot.recording import Truth

IMMOVABLE = 1e-9
"""Singular values of the tool's Jacobian below this part of the largest are directions in which the
tool does not move, and has no covariance."""


def consistency(
    known: ArmEstimator,
    path: Callable[[Array], Array],
    fit: ParameterEstimate,
    run: Run,
    truth: Truth,
    robot: RobotModel,
) -> dict[str, Any]:
    """Normalised squares of the filter's innovations and of the tool's error.

    NIS and NEES are 6 and 3 on average where the estimate is consistent, NEES 2 where the tool
    moves in a plane. The filter alone takes springs and motor angles for exact.

    path: tool path (N, 3) [m] at the instants of the log, estimated with parameters theta (m,).
    """
    states = known.deviations(run)
    seen = np.isfinite(states.innovation).all(axis=1)
    nis = normalised_squared(states.innovation[seen], states.innovation_covariance[seen])

    rows = np.rint((run.imu_time + known.clock_offset) / run.period).astype(int)
    inside = (rows >= 0) & (rows < len(run.time))
    rows = np.clip(rows, 0, len(run.time) - 1)
    moving = directions(known.model.tool[:3, : known.model.n_free])
    T = moving.T @ known.model.tool[:3]
    of_filter = T @ known.smoother(run).smoothed_covariance @ T.T
    P = tool_covariance(known, run, fit, lambda theta: path(theta)[rows], robot)
    P = moving.T @ P @ moving
    true = relative_to_start(truth.tool_position[:: round(run.period / float(truth.time[1]))])
    error = ((path(fit.theta) - true[:, :3])[rows] @ moving)[inside]
    return {
        "nis": float(nis.mean()),
        "nis_expected": bounds(len(nis), 6),
        "nees": float(normalised_squared(error, P[inside]).mean()),
        "nees_of_filter": float(normalised_squared(error, of_filter[inside]).mean()),
        "nees_expected": float(moving.shape[1]),
        "tool_error": float(np.sqrt(np.square(error).sum(axis=1).mean())),
        "tool_standard_deviation": float(np.sqrt(np.trace(P[inside].mean(axis=0)))),
    }


def directions(jacobian: Array) -> Array:
    """(3, r) basis of the directions in which a tool moves, by its Jacobian (3, n) of positions."""
    U, size, _ = np.linalg.svd(jacobian)
    rank = int((size > IMMOVABLE * size[0]).sum())
    return np.eye(3) if rank == len(U) else U[:, :rank]
