"""Identification of an arm from one cut, scored against the ground truth."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from armside.arrays import Array

from ..cut.notes import motion_notes
from ..estimation.arm_estimator import estimator
from ..estimation.arm_filter import ProcessNoise
from ..estimation.arm_identification import identify, prepared
from ..estimation.arm_springs import SpringPrior, springs_at
from ..estimation.imu_health import repaired
from ..estimation.linearised_arm import linearised
from ..estimation.nominal import NominalArm, NominalCfg, nominal_arm
from ..estimation.springs_file import springs_entry
from ..instruments.imu import ImuCfg
from ..robot.individual import as_built
from .consistency import consistency
from .experiment import Experiment, Pass
from .learning import first_run
from .results import pass_notes

UNTOLD = 0.5
"""Relative reduction of a parameter's prior variance below which the cut does not identify it: the
prior says more than the data."""
FOUND = 0.1
"""Largest relative distance of an identified mode from the true one that it counts as."""


def identified(experiment: Experiment, arm: NominalArm, *, coupled: bool = True) -> dict[str, Any]:
    """Springs identified from one cut, as `armside identify` writes them, beside the ground truth.

    Args:
        arm: the assumed arm.
        coupled: structure in series may couple the axes; else springs of the gears alone.

    Raises:
        ImuError: the IMU cannot be used.
    """
    made, unit, imu = first_run(experiment), experiment.plant.imu, experiment.cut.imu
    log, made_notes = made.recording, pass_notes(experiment, made)
    assert made.imu is not None
    assert unit is not None
    assert imu is not None
    measured = prepared(arm, log.time, log.motor_angle, repaired(made.imu, imu))
    prior = SpringPrior() if coupled else SpringPrior(coupling=0.0)
    rest = log.motor_angle[0]
    found = identify(arm, measured, rest, imu, prior=prior)

    true_arm = arm_of(experiment)
    gear = np.diag(true_arm.stiffness)
    modes = linearised(true_arm, rest).locked_modes()[:4]
    found_modes = linearised(found.springs.on(arm), rest).locked_modes()
    fit, keys = found.fit, ("name", "value", "standard_deviation", "told_by_data")
    parameters = zip(found.names, fit.theta, fit.standard_deviation, fit.information, strict=True)
    return {
        "springs": springs_entry(found.springs),
        "place": experiment.cut.tool_pose.position,
        "parameters": [dict(zip(keys, row, strict=True)) for row in parameters],
        "not_identified": unidentified(found.names, fit.information),
        "costs": fit.costs,
        "notes": [*motion_notes(experiment.motion, experiment.cut.limits), *made_notes],
        "whiteness": {
            name: getattr(found.whiteness, name) for name in ("rms", "p_value", "is_white")
        },
        "consistency": consistency(
            estimator(arm, found.springs, rest, imu),
            _at_theta(arm, prior, rest, imu, made),
            found.fit,
            measured,
            log.truth,
            experiment.nominal,
        ),
        "truth": {
            "gear_stiffness": gear,
            "believed_over_true": effective(arm.stiffness) / gear,
            "identified_over_true": effective(found.springs.stiffness) / gear,
            "clock_offset": unit.unit.clock_offset,
            "locked_modes": modes,
            "identified_modes": found_modes[:4],
            "identified_as": assigned(modes, found_modes),
            "believed_modes": linearised(arm, rest).locked_modes()[:4],
        },
    }


def _at_theta(
    arm: NominalArm, prior: SpringPrior, rest: Array, imu: ImuCfg, made: Pass
) -> Callable[[Array], Array]:
    """Tool path (N, 3) [m] of a run, estimated on the springs of parameters theta (m,)."""
    log, fraction = made.recording, ProcessNoise().fraction

    def path(theta: Array) -> Array:
        known = estimator(arm, springs_at(arm, prior, theta, fraction), rest, imu)
        return known(log.time, log.motor_angle, made.imu).displacement[:, :3]

    return path


def unidentified(names: Sequence[str], information: Array) -> list[str]:
    """Parameters that keep their prior: the data reduce its variance by less than `UNTOLD`."""
    return [name for name, told in zip(names, information, strict=True) if told < UNTOLD]


def effective(stiffness: Array) -> Array:
    """Stiffness of each axis (n,) against a torque of its own, all springs free: 1 / diag(K^-1).

    The diagonal of a coupled K is the stiffness with all other axes held, which is larger.
    """
    return np.asarray(1.0 / np.diag(np.linalg.inv(stiffness)), dtype=np.float64)


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
