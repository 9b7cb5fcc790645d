"""Identification of a twin: regularised Gauss-Newton on torque and tool, by turns with simulation.

    minimise sum_i |torque residual_i / s_i|^2 + |tool residual / s|^2 + |(theta - mean) / prior|^2

The scales s follow from the residuals themselves: what a model does not explain lasts for many
samples and must not count as if it were noise.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import reduce
from itertools import repeat
from operator import add

import numpy as np

from armside.arrays import Array

from ..robot.individual import structure_hinges
from ..robot.mjcf import N_AXES
from ..robot.run import cores
from .parameters import FRICTION, MASS, Parameters, tool_blocks
from .recordings import MeasuredCut
from .sensitivities import Against, Columns, Residuals
from .simulation import RobotDesign
from .tool_sensor import TRACKER, ToolSensor

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


_AT_ONCE = 4
"""Cuts at most, whose simulations and equations are under way: what is Python in one goes on while
the physics of others runs. ESTIMATE of what keeps the cores of a small machine busy."""


@dataclass(frozen=True, kw_only=True)
class Identification:
    """Options of identification."""

    steps: int = 6
    """Of Gauss-Newton."""
    linearised: tuple[int, ...] = (0, 1, 3, 5)
    """Steps that compute sensitivities anew; the others keep the last."""
    correlation: float = 3.0
    """Scale of torque residuals over their root mean square, as if samples were independent."""
    torque_noise: float = 5e-4
    """Least scale of torque over the torque limit."""


@dataclass(frozen=True, eq=False)
class Quality:
    """Residuals that a twin leaves of the cuts it was identified from."""

    scales: Array
    """Of torque residuals [N m], motor side, and of the tool's sensor."""
    held_out: Array
    within: Array
    """(c,), root mean square of the tool's residual of each cut, left out and included: [m] of a
    tracker, of an IMU over its white noise."""
    torque: Array
    """(c, 6) [N m], root mean square of the torque residual of each cut."""


@dataclass(frozen=True, eq=False)
class IdentifiedParameters:
    """Parameters with their posterior covariance."""

    parameters: Parameters
    theta: Array
    covariance: Array
    """(m, m), of the linearised model at theta."""
    quality: Quality


def torque_rms(residual: Residuals) -> Array:
    """(6,) [N m], root mean square of the torque residual while the arm moves."""
    return np.sqrt(np.mean(residual.torque[residual.moving] ** 2, axis=0))


def parameters_of(design: RobotDesign) -> Parameters:
    """All unknown parameters of individuals of a design."""
    return Parameters((*FRICTION, MASS, *tool_blocks(len(structure_hinges(design.model)))))


def identify(
    design: RobotDesign,
    cuts: Sequence[MeasuredCut],
    cfg: Identification = Identification(),
    progress: Callable[[], None] = lambda: None,
    *,
    sensor: ToolSensor = TRACKER,
) -> IdentifiedParameters:
    """Identify an individual from recorded cuts.

    The first step moves friction and masses alone, by torque: what the tool does before the motors
    move as they should would be taken for springs.
    """
    parameters = parameters_of(design)
    each = [Against(design, parameters, cut, sensor) for cut in cuts]
    torque_noise = cfg.torque_noise * design.model.drives.torque_limit
    least = np.append(torque_noise, sensor.noise)
    correlation = np.append(np.full(N_AXES, cfg.correlation), sensor.correlation)
    solving = Solving(parameters, parameters.mean, least, correlation)
    found, last = list[Compared](), solving
    covariance, scales = np.diag(parameters.standard_deviation**2), least
    with ThreadPoolExecutor(min(cores(), _AT_ONCE)) as pool:
        for step in range(cfg.steps):
            anew = step in cfg.linearised
            known = [None] * len(each) if anew else [cut.columns for cut in found]
            found = list[Compared]()
            for cut in pool.map(compared, each, repeat(solving.theta), known):
                found.append(cut)
                progress()
            groups, last = together(found), solving
            solved = solving.solve(groups[:N_AXES] if step == 0 else groups)
            solving = replace(solving, theta=solving.theta + solved.change)
            covariance, scales = solved.covariance, solved.scales
    without, within = held_out(last, found)
    torque = np.array([torque_rms(cut.residuals) for cut in found])
    quality = Quality(scales, without, within, torque)
    return IdentifiedParameters(parameters, solving.theta, covariance, quality)
