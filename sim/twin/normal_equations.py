"""Bounded least squares in a twin's parameters, from residuals of torque and tool.

The scale of a sensor's residuals follows from the residuals themselves: what a model does not
explain lasts for many samples and must not count as if it were noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np

from armside.arrays import Array

from ..robot.mjcf import N_AXES
from .parameters import Parameters
from .sensitivities import Against, Columns, Residuals

_SCALINGS = 4
"""Turns of scales and solution."""


@dataclass(frozen=True, eq=False)
class Group:
    """Residuals of one sensor as normal equations: A^T A, A^T b, b^T b."""

    information: Array
    gradient: Array
    power: float
    rows: int

    def __add__(self, other: "Group") -> "Group":
        """Normal equations of the residuals of both."""
        return Group(
            self.information + other.information,
            self.gradient + other.gradient,
            self.power + other.power,
            self.rows + other.rows,
        )

    def left(self, change: Array) -> float:
        """Root mean square of the residual after a change of theta."""
        quadratic = change @ self.information @ change - 2.0 * change @ self.gradient
        return float(np.sqrt(max(self.power + quadratic, 0.0) / self.rows))


@dataclass(frozen=True, eq=False)
class Compared:
    """One cut against a twin: residuals, their sensitivities, and both as normal equations."""

    residuals: Residuals
    columns: Columns
    groups: Sequence[Group]
    """Torque of each axis, then the tool's sensor."""


def compared(against: Against, theta: Array, columns: Columns | None) -> Compared:
    """A cut against the twin of theta, with sensitivities from before, or anew if None."""
    if columns is None:
        residuals, columns = against.linearised(theta)
    else:
        residuals = against.residuals(theta)
    on, m = residuals.moving, columns.tool.shape[-1]
    torque = [
        _group(columns.torque[on, axis], residuals.torque[on, axis]) for axis in range(N_AXES)
    ]
    tool = _group(columns.tool.reshape(-1, m), residuals.tool.ravel())
    return Compared(residuals, columns, [*torque, tool])


def together(cuts: Sequence[Compared]) -> list[Group]:
    """Normal equations of several cuts."""
    return [reduce(add, groups) for groups in zip(*(cut.groups for cut in cuts), strict=True)]


def _group(A: Array, b: Array) -> Group:
    return Group(A.T @ A, A.T @ b, float(b @ b), len(b))


@dataclass(frozen=True, eq=False)
class Solved:
    """Change of theta, its posterior covariance, and the scales of the residuals."""

    change: Array
    covariance: Array
    scales: Array


@dataclass(frozen=True, eq=False)
class Solving:
    """Bounded least squares around theta, with scales that follow from its own residuals."""

    parameters: Parameters
    theta: Array
    least: Array
    """(g,), least scales of the groups."""
    correlation: Array
    """(g,), scale of residuals over their root mean square, as if samples were independent."""

    def solve(self, groups: Sequence[Group]) -> Solved:
        """Parameters that no group depends on keep their value."""
        from scipy.optimize import lsq_linear

        parameters, theta = self.parameters, self.theta
        least, correlation = self.least[: len(groups)], self.correlation[: len(groups)]
        seen = np.flatnonzero(sum(np.diag(group.information) for group in groups) > 0.0)
        precision = parameters.standard_deviation[seen] ** -2.0
        pull = (parameters.mean - theta)[seen] * precision
        lower = np.maximum(parameters.lower - theta, -parameters.step)[seen]
        upper = np.minimum(parameters.upper - theta, parameters.step)[seen]
        change, whole, scales = np.zeros(len(theta)), np.diag(precision), least
        for _ in range(_SCALINGS):
            scales = np.maximum(correlation * [g.left(change) for g in groups], least)
            weighed = list(zip(groups, scales, strict=True))
            whole = sum(g.information[seen[:, None], seen] / s**2 for g, s in weighed)
            whole = whole + np.diag(precision)
            gradient = sum(g.gradient[seen] / s**2 for g, s in weighed) + pull
            root = np.linalg.cholesky(whole).T
            change[seen] = lsq_linear(
                root, np.linalg.solve(root.T, gradient), bounds=(lower, upper)
            ).x
        covariance = np.diag(parameters.standard_deviation**2)
        covariance[seen[:, None], seen] = np.linalg.inv(whole)
        return Solved(change, covariance, scales)


def held_out(solving: Solving, cuts: Sequence[Compared]) -> tuple[Array, Array]:
    """Root mean square of the tool's residual of each cut, left out and included: (c,), (c,).

    In the unit of the sensor. A single cut cannot be left out: NaN.
    """
    whole = solving.solve(together(cuts)).change
    without = [_tool_residual(cut, _left_out(solving, cuts, cut)) for cut in cuts]
    within = [_tool_residual(cut, whole) for cut in cuts]
    return np.array(without), np.array(within)


def _left_out(solving: Solving, cuts: Sequence[Compared], cut: Compared) -> Array:
    others = [other for other in cuts if other is not cut]
    if not others:
        return np.full(solving.parameters.size, np.nan)
    return solving.solve(together(others)).change


def _tool_residual(cut: Compared, change: Array) -> float:
    left = cut.residuals.tool - cut.columns.tool @ change
    return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))
