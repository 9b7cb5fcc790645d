"""Identification of a twin: regularised Gauss-Newton on torque and tool, by turns with simulation.

    minimise sum_i |torque residual_i / s_i|^2 + |tool residual / s|^2 + |(theta - mean) / prior|^2

The scales s follow from the residuals themselves: what a model does not explain lasts for many
samples and must not count as if it were noise.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from armside.arrays import Array

from ..robot.individual import structure_hinges
from ..robot.mjcf import N_AXES
from .bending import BENDING
from .measured import MeasuredCut
from .parameters import FRICTION, MASS, Parameters, tool_blocks
from .sensitivities import Against, Columns, Residuals
from .simulation import Design


@dataclass(frozen=True, kw_only=True)
class Identification:
    """Options of identification."""

    steps: int = 5
    """Of Gauss-Newton."""
    linearised: tuple[int, ...] = (0, 2)
    """Steps that compute sensitivities anew; the others keep the last."""
    correlation: float = 3.0
    """Scale of residuals over their root mean square, as if samples were independent."""
    torque_noise: float = 5e-4
    """Least scale of torque over the torque limit."""
    tool_noise: float = 10e-6
    """Least scale of the tool's position [m]."""


@dataclass(frozen=True, eq=False)
class Identified:
    """Parameters with their posterior covariance."""

    parameters: Parameters
    theta: Array
    covariance: Array
    """(m, m), of the linearised model at theta."""
    scales: Array
    """(7,): of torque residuals [N m], motor side, and of the tool [m]."""


def parameters_of(design: Design) -> Parameters:
    """All unknown parameters of individuals of a design."""
    n_structure = len(structure_hinges(design.model)) - len(BENDING)
    return Parameters((*FRICTION, MASS, *tool_blocks(n_structure, len(BENDING))))


def identify(
    design: Design,
    cuts: Sequence[MeasuredCut],
    cfg: Identification = Identification(),
    progress: Callable[[], None] = lambda: None,
) -> Identified:
    """Identify an individual from recorded cuts.

    The first step moves friction and masses alone, by torque: what the tool does before the motors
    move as they should would be taken for springs.
    """
    parameters = parameters_of(design)
    each = [Against(design, parameters, cut) for cut in cuts]
    limits = design.model.drives.torque_limit
    least = np.append(cfg.torque_noise * limits, cfg.tool_noise)
    theta, columns = parameters.mean, list[Columns]()
    solved = None
    for step in range(cfg.steps):
        residuals = []
        for i, against in enumerate(each):
            if step in cfg.linearised:
                found, sensitive = against.linearised(theta)
                columns[i : i + 1] = [sensitive]
            else:
                found = against.residuals(theta)
            residuals.append(found)
            progress()
        groups = _groups(residuals, columns)
        if step == 0:
            groups = groups[:N_AXES]
        solved = _solve(parameters, theta, groups, least, cfg.correlation)
        theta = theta + solved.change
    assert solved is not None
    return Identified(parameters, theta, solved.covariance, solved.scales)


@dataclass(frozen=True, eq=False)
class Group:
    """Residuals of one sensor as normal equations: A^T A, A^T b, b^T b."""

    information: Array
    gradient: Array
    power: float
    rows: int

    def left(self, change: Array) -> float:
        """Root mean square of the residual after a change of theta."""
        quadratic = change @ self.information @ change - 2.0 * change @ self.gradient
        return float(np.sqrt(max(self.power + quadratic, 0.0) / self.rows))


def _groups(residuals: Sequence[Residuals], columns: Sequence[Columns]) -> list[Group]:
    """Torque of each axis, then the tool."""
    pairs = list(zip(residuals, columns, strict=True))
    torque = [
        _group([(c.torque[r.moving, axis], r.torque[r.moving, axis]) for r, c in pairs])
        for axis in range(N_AXES)
    ]
    m = columns[0].tool.shape[-1]
    return [*torque, _group([(c.tool.reshape(-1, m), r.tool.ravel()) for r, c in pairs])]


def _group(parts: Sequence[tuple[Array, Array]]) -> Group:
    information = sum(A.T @ A for A, _ in parts)
    gradient = sum(A.T @ b for A, b in parts)
    power, rows = sum(float(b @ b) for _, b in parts), sum(len(b) for _, b in parts)
    return Group(np.asarray(information), np.asarray(gradient), power, rows)


@dataclass(frozen=True, eq=False)
class Solved:
    change: Array
    covariance: Array
    scales: Array


def _solve(
    parameters: Parameters, theta: Array, groups: Sequence[Group], least: Array, correlation: float
) -> Solved:
    """Bounded least squares, with scales that follow from its own residuals.

    Parameters that no group depends on keep their value.
    """
    seen = np.flatnonzero(sum(np.diag(group.information) for group in groups) > 0.0)
    precision = parameters.standard_deviation[seen] ** -2.0
    pull = (parameters.mean - theta)[seen] * precision
    bounds = (parameters.lower - theta)[seen], (parameters.upper - theta)[seen]
    change = np.zeros(len(theta))
    whole, scales = np.diag(precision), np.zeros(len(groups))
    for _ in range(_SCALINGS):
        scales = np.maximum([correlation * g.left(change) for g in groups], least[: len(groups)])
        weighed = list(zip(groups, scales, strict=True))
        whole = sum(g.information[np.ix_(seen, seen)] / s**2 for g, s in weighed)
        whole = whole + np.diag(precision)
        gradient = sum(g.gradient[seen] / s**2 for g, s in weighed) + pull
        root = np.linalg.cholesky(whole).T
        change[seen] = lsq_linear(root, np.linalg.solve(root.T, gradient), bounds=bounds).x
    covariance = np.diag(parameters.standard_deviation**2)
    covariance[np.ix_(seen, seen)] = np.linalg.inv(whole)
    return Solved(change, covariance, scales)


_SCALINGS = 4
"""Turns of scales and solution."""
