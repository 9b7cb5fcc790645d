"""Region of configurations in which a calibration may be used.

Each joint variable must lie near those that were fitted: harmonics do not extrapolate.
The posterior's own standard deviation of a predicted point must not exceed the fit's residual:
geometry that was seen in one corner of the workspace is not known in another.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..dh import Robot
from .fit import Fit, jacobian_of_points

MARGIN = 0.1
"""[rad or m] Largest distance of a joint variable from the range of the fitted ones."""
GAP = 0.4
"""[rad or m] Largest distance from the nearest fitted one within their range."""
TRUSTED = 3.0
"""Standard deviation of a predicted point, relative to the root mean square residual of the fit of
the geometry. The posterior is two to three times too careful where few poses were fitted."""


@dataclass(frozen=True, eq=False)
class Region:
    """Configurations that a fit may be used for."""

    robot: Robot
    values: tuple[Array, ...]
    """Fitted values of each joint variable, sorted."""
    fit: Fit
    largest: float
    """Standard deviation of a predicted point that is still trusted [m]."""

    def near(self, phi: Array) -> NDArray[np.bool_]:
        """True for each joint, (N, n), whose variable is in the range of the fitted ones."""
        q = self.robot.joint_variables(phi)
        columns = [_near(q[:, i], own) for i, own in enumerate(self.values)]
        return np.column_stack(columns)

    def contains(self, phi: Array) -> NDArray[np.bool_]:
        """True for each configuration (N, n) in the region."""
        return self.near(phi).all(axis=1) & (self.standard_deviation(phi) <= self.largest)

    def standard_deviation(self, phi: Array) -> Array:
        """Standard deviation (N,) of the predicted first target [m], by the posterior."""
        J = jacobian_of_points(self.fit, phi)
        return np.sqrt(((J @ self.fit.covariance) * J).sum(axis=(1, 2)))

    def check(self, phi: Array) -> None:
        """Raise ValueError for configurations outside; the message names joint and angle."""
        outside = np.flatnonzero(~self.contains(phi))
        if not outside.size:
            return
        first, text = int(outside[0]), f"{outside.size} of {len(phi)} configurations"
        bad = np.flatnonzero(~self.near(phi[first : first + 1])[0])
        why = "the parameters do not determine the tool there"
        if bad.size:
            q = self.robot.joint_variables(phi[first])[bad[0]]
            why = f"joint {bad[0] + 1} at {q:.3g} is too far from those that were fitted"
        raise ValueError(f"{text} lie outside of what was calibrated: in number {first + 1} {why}")


def region(fit: Fit, geometry: Fit) -> Region:
    """Region of a fit; `geometry` is the fit of the same poses without joint errors."""
    robot = fit.problem.model.robot
    q = robot.joint_variables(fit.problem.data.phi)
    lengths = geometry.lengths[np.isfinite(geometry.lengths)]
    rms = float(np.sqrt(np.mean(lengths**2)))
    return Region(robot, tuple(np.unique(column) for column in q.T), fit, TRUSTED * rms)


def _near(values: Array, fitted: Array) -> NDArray[np.bool_]:
    """True for values near one of the fitted, which are sorted."""
    place = np.searchsorted(fitted, values)
    left = np.abs(values - fitted[np.maximum(place - 1, 0)])
    right = np.abs(values - fitted[np.minimum(place, len(fitted) - 1)])
    within = (place > 0) & (place < len(fitted))
    return np.minimum(left, right) <= np.where(within, GAP, MARGIN)
