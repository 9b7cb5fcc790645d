"""Consistency of the tool's estimate with the ground truth: NIS and NEES of one run."""

from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import bounds, normalised_squared
from armside.ilc.estimation.prediction_error import ParameterEstimate

from ..estimation.elasticity import Elasticity
from ..estimation.estimator import ToolEstimate, ToolEstimator
from ..estimation.relative_path import relative_to_start
from ..estimation.tool_covariance import tool_covariance
from ..robot.model import RobotModel
from ..robot.recording import Truth

IMMOVABLE = 1e-9
"""Singular values of the tool's Jacobian below this part of the largest are directions in which the
tool does not move, and has no covariance."""
MOVING = 0.4
"""Beginning of a run [s] that is not judged: the arm rests, and the path counts from there."""


def consistency(
    known: ToolEstimator,
    fit: ParameterEstimate,
    nominal: Elasticity,
    estimate: ToolEstimate,
    truth: Truth,
    robot: RobotModel,
) -> dict[str, Any]:
    """Normalised squares of the filter's innovations and of the tool's error, in the first run.

    NIS and NEES are 6 and 3 on average where the estimate is consistent, NEES 2 where the tool
    moves in a plane. The filter alone takes springs and motor angles for exact.
    """
    white = estimate.innovation[np.isfinite(estimate.innovation).all(axis=1)]
    nis = np.square(white).sum(axis=1)
    time, model = known.along.time, known.models[0]
    rows = time > MOVING
    moving = directions(model.tool[:3, : model.n_free])
    of_filter = moving.T @ known.filter_covariance[known.place] @ moving
    P = moving.T @ tool_covariance(known, fit, nominal, robot) @ moving
    every = round(known.along.period / float(truth.time[1]))
    true = relative_to_start(truth.tool_position[::every])
    error: Array = ((estimate.displacement - true)[:, :3] @ moving)[rows]
    return {
        "nis": float(nis.mean()),
        "nis_expected": bounds(len(nis), 6),
        "nees": float(normalised_squared(error, P[rows]).mean()),
        "nees_of_filter": float(normalised_squared(error, of_filter[rows]).mean()),
        "nees_expected": float(moving.shape[1]),
        "tool_error": float(np.sqrt(np.square(error).sum(axis=1).mean())),
        "tool_standard_deviation": float(np.sqrt(np.trace(P[rows].mean(axis=0)))),
    }


def directions(jacobian: Array) -> Array:
    """(3, r) basis of the directions in which a tool moves, by its Jacobian (3, n) of positions."""
    U, size, _ = np.linalg.svd(jacobian)
    rank = int((size > IMMOVABLE * size[0]).sum())
    return np.eye(3) if rank == len(U) else U[:, :rank]
