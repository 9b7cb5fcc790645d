"""Identification of an arm from one cut, scored against the ground truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.consistency import bounds, normalised_squared
from armside.ilc.estimation.prediction_error import ParameterEstimate

from ..estimation.elasticity import Elasticity, names, nominal_elasticity, springs_entry
from ..estimation.estimator import ToolEstimate, ToolEstimator
from ..estimation.identification import identify
from ..estimation.imu_health import repaired
from ..estimation.linearised_arm import linearised
from ..estimation.nominal import NominalArm, NominalCfg, nominal_arm
from ..estimation.relative_path import relative_to_start
from ..estimation.rigid_motion import rigid_motion
from ..estimation.tool_covariance import tool_covariance
from ..motion.tool_motion import motion_notes
from ..robot.individual import as_built
from ..robot.model import RobotModel
from ..robot.recording import Truth
from .experiment import Experiment
from .loop import first_run
from .results import pass_notes

UNIDENTIFIED = 0.5
"""Relative reduction of a parameter's prior variance below which the cut does not identify it: the
prior says more than the data."""
FOUND = 0.1
"""Largest relative distance of an identified mode from the true one that it counts as."""
IMMOVABLE = 1e-9
"""Singular values of the tool's Jacobian below this part of the largest are directions in which the
tool does not move, and has no covariance."""
MOVING = 0.4
"""Beginning of a run [s] that is not judged: the arm rests, and the path counts from there."""


def identified(experiment: Experiment, arm: NominalArm) -> dict[str, Any]:
    """Springs identified from one cut, as `armside identify` writes them, beside the ground truth.

    arm: the assumed arm, `ToolPath.assumed`. Raises ImuError where the IMU cannot be used.
    """
    made, unit, imu = first_run(experiment), experiment.plant.imu, experiment.cut.imu
    log, made_notes = made.recording, pass_notes(experiment, made)
    assert made.imu is not None
    assert unit is not None
    assert imu is not None
    motion, samples = rigid_motion(arm, log.time, log.motor_angle), repaired(made.imu, imu)
    nominal = nominal_elasticity(experiment.nominal, arm)
    found = identify(motion, nominal, samples, imu)
    known = ToolEstimator(arm, found.parameters, imu, motion)
    estimate = known(log.time, log.motor_angle, samples)

    true_arm = arm_of(experiment)
    gear, springs = true_arm.stiffness, found.parameters.springs
    modes = linearised(true_arm, log.motor_angle[0]).locked_modes()[:4]
    found_modes = motion.linearised(0, springs).locked_modes()
    fit, keys = found.fit, ("name", "value", "standard_deviation", "identified")
    named = names(nominal)
    parameters = zip(named, fit.theta, fit.standard_deviation, fit.information, strict=True)
    return {
        "springs": springs_entry(found.parameters),
        "parameters": [dict(zip(keys, row, strict=True)) for row in parameters],
        "not_identified": unidentified(named, fit.information),
        "costs": fit.costs,
        "notes": [*motion_notes(experiment.motion, experiment.cut.limits), *made_notes],
        "whiteness": {
            name: getattr(found.whiteness, name) for name in ("rms", "p_value", "is_white")
        },
        "consistency": consistency(known, fit, nominal, estimate, log.truth, experiment.nominal),
        "truth": {
            "gear_stiffness": gear,
            "assumed_over_true": nominal.stiffness[nominal.axes] / gear,
            "identified_over_true": springs.stiffness[springs.axes] / gear,
            "clock_offset": unit.unit.clock_offset,
            "locked_modes": modes,
            "identified_modes": found_modes[:4],
            "identified_as": assigned(modes, found_modes),
            "assumed_modes": motion.linearised(0, nominal).locked_modes()[:4],
        },
    }


def unidentified(names: Sequence[str], information: Array) -> list[str]:
    """Parameters that keep their prior, whose variance the data reduce by less than that."""
    return [name for name, known in zip(names, information, strict=True) if known < UNIDENTIFIED]


def assigned(true: Array, found: Array) -> list[float | None]:
    """For each true mode the one found within `FOUND` of it, each used once; None without one."""
    from scipy.optimize import linear_sum_assignment

    apart = np.abs(np.asarray(found) / np.asarray(true)[:, None] - 1.0)
    rows, columns = linear_sum_assignment(np.minimum(apart, 2.0 * FOUND))
    pairs = zip(rows, columns, strict=True)
    chosen = {i: float(found[j]) for i, j in pairs if apart[i, j] <= FOUND}
    return [chosen.get(i) for i in range(len(true))]


def arm_of(experiment: Experiment) -> NominalArm:
    """The individual itself as the arm of an estimator: linear gears and all of its structure."""
    truth = NominalCfg(structure=True, payload=experiment.added_payload)
    return nominal_arm(as_built(experiment.nominal, experiment.individual), truth)


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
