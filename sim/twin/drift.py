"""Friction that has changed since commissioning, from the torque of production runs.

    torque residual_i = (dF_i / d log f_i) log f_i        log f_i ~ N(0, 0.15^2)

One factor for each axis, which covers temperature and wear alike: what it leaves of the torque says
when the robot should be commissioned again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array

from .recordings import MeasuredCut
from .simulation import RobotDesign
from .twin import Twin

_PRIOR = 0.15
"""Standard deviation of log(factor). ESTIMATE."""
_STEP = 0.05
_TURNS = 2
_LARGEST_DRIFT = 0.3
_LARGEST_GROWTH = 4.0
"""Torque residual over that at commissioning, from which on a robot is commissioned again."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Refreshed:
    """A twin after production runs."""

    twin: Twin
    growth: Array
    """(6,), torque residual over that of the commissioning cuts."""

    @property
    def advice(self) -> str | None:
        """Reason to commission the robot again; None where there is none."""
        drift = np.abs(np.log(self.twin.friction))
        if drift.max() > np.log1p(_LARGEST_DRIFT):
            axis = int(drift.argmax())
            factor = self.twin.friction[axis]
            return f"friction of axis {axis + 1} is {factor:.2f} times that at commissioning"
        if self.growth.max() > _LARGEST_GROWTH:
            axis = int(self.growth.argmax())
            return (
                f"torque of axis {axis + 1} is no longer explained: {self.growth[axis]:.1f} times"
            )
        return None


def refreshed(twin: Twin, runs: Sequence[MeasuredCut], payload: float | None = None) -> Refreshed:
    """The twin with the friction that production runs show.

    payload: mass of the tool in these runs [kg]; that of the robot's file if None.
    """
    design = twin.design_with(payload)
    least = 1e-3 * design.model.drives.torque_limit
    noise = np.maximum(3.0 * twin.torque_residual, least)
    for _ in range(_TURNS):
        information, gradient = np.full(6, _PRIOR**-2.0), -np.log(twin.friction) * _PRIOR**-2.0
        for run in runs:
            slope, residual = _sensitivity(design, twin, run)
            information = information + np.sum(slope**2, axis=0) / noise**2
            gradient = gradient + np.sum(slope * residual, axis=0) / noise**2
        twin = replace(twin, friction=twin.friction * np.exp(gradient / information))
    left = np.mean([np.mean(_residual(design, twin, run) ** 2, axis=0) for run in runs], axis=0)
    return Refreshed(twin=twin, growth=np.sqrt(left) / np.maximum(twin.torque_residual, least))


def _sensitivity(design: RobotDesign, twin: Twin, run: MeasuredCut) -> tuple[Array, Array]:
    more = replace(twin.individual, friction=twin.friction * np.exp(_STEP))
    base, other = design.run([twin.individual, more], run.reference, run.correction)
    slope = (other.motor_torque - base.motor_torque) / _STEP
    return slope[run.moving], (run.motor_torque - base.motor_torque)[run.moving]


def _residual(design: RobotDesign, twin: Twin, run: MeasuredCut) -> Array:
    simulated = design.run([twin.individual], run.reference, run.correction)[0]
    return (run.motor_torque - simulated.motor_torque)[run.moving]
