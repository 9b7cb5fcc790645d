"""Identification of a twin: regularised Gauss-Newton on torque and tool, by turns with simulation.

    minimise sum_i |torque residual_i / s_i|^2 + |tool residual / s|^2 + |(theta - mean) / prior|^2

The scales s follow from the residuals themselves: what a model does not explain lasts for many
samples and must not count as if it were noise.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import repeat
from typing import NamedTuple

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

CORRELATION = 3.0
"""Scale of torque residuals over their root mean square, as if samples were independent."""
TORQUE_NOISE = 5e-4
"""Least scale of torque over the torque limit."""
_AT_ONCE = 4
"""Cuts at most, whose simulations and equations are under way: what is Python in one goes on while
the physics of others runs. ESTIMATE of what keeps the cores of a small machine busy."""
_SCALINGS = 4
"""Turns of scales and solution."""


class Group(NamedTuple):
    """Residuals of one sensor as normal equations: A^T A, A^T b, b^T b."""

    information: Array
    gradient: Array
    power: float
    rows: int

    def left(self, change: Array) -> float:
        """Root mean square of the residual after a change of theta."""
        quadratic = change @ self.information @ change - 2.0 * change @ self.gradient
        return float(np.sqrt(max(self.power + quadratic, 0.0) / max(self.rows, 1)))


@dataclass(frozen=True, eq=False)
class Compared:
    """One cut against a twin: residuals, their sensitivities, and both as normal equations."""

    residuals: Residuals
    columns: Columns
    groups: Sequence[Group]
    """Torque of each axis, then each kind of the tool's sensors: nothing but of this cut's."""

    def tool_residual(self, change: Array) -> float:
        """Root mean square after a change of theta, in the unit of the sensor."""
        left = self.residuals.tool - self.columns.tool @ change
        return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))


def compared(
    against: Against,
    theta: Array,
    columns: Columns | None,
    kinds: Sequence[ToolSensor] | None = None,
    tool: bool = True,
) -> Compared:
    """A cut against the twin of theta, with sensitivities from before, or anew if None.

    kinds: of sensors that the cuts were seen by; that of this cut if None. tool: as of
    `Against.linearised`.
    """
    if columns is None:
        residuals, columns = against.linearised(theta, tool=tool)
    else:
        residuals = against.residuals(theta)
    on, m = residuals.moving, columns.tool.shape[-1]
    equations = [(columns.torque[on, i], residuals.torque[on, i]) for i in range(N_AXES)]
    for kind in [against.sensor] if kinds is None else kinds:
        rows = slice(None) if kind is against.sensor else slice(0)
        equations.append((columns.tool[rows].reshape(-1, m), residuals.tool[rows].ravel()))
    groups = [Group(A.T @ A, A.T @ b, float(b @ b), len(b)) for A, b in equations]
    return Compared(residuals, columns, groups)


def together(cuts: Sequence[Compared]) -> list[Group]:
    """Normal equations of several cuts."""
    every = zip(*(cut.groups for cut in cuts), strict=True)
    return [Group._make(sum(part) for part in zip(*each, strict=True)) for each in every]


@dataclass(frozen=True, eq=False)
class Solving:
    """Bounded least squares around theta, with scales that follow from its own residuals."""

    parameters: Parameters
    theta: Array
    least: Array
    """(g,), least scales of the groups."""
    correlation: Array
    """(g,), scale of residuals over their root mean square, as if samples were independent."""

    def solve(self, groups: Sequence[Group]) -> tuple[Array, Array]:
        """Change of theta, of what groups depend on, and its posterior covariance."""
        from scipy.optimize import lsq_linear

        parameters, theta = self.parameters, self.theta
        least, correlation = self.least[: len(groups)], self.correlation[: len(groups)]
        seen = np.flatnonzero(sum(np.diag(group.information) for group in groups) > 0.0)
        precision = parameters.standard_deviation[seen] ** -2.0
        pull = (parameters.mean - theta)[seen] * precision
        lower = np.maximum(parameters.lower - theta, -parameters.step)[seen]
        upper = np.minimum(parameters.upper - theta, parameters.step)[seen]
        change, whole = np.zeros(len(theta)), np.diag(precision)
        for _ in range(_SCALINGS):
            scales = np.maximum(correlation * [g.left(change) for g in groups], least)
            weighed = list(zip(groups, scales, strict=True))
            whole = sum(g.information[seen[:, None], seen] / s**2 for g, s in weighed)
            whole = whole + np.diag(precision)
            gradient = sum(g.gradient[seen] / s**2 for g, s in weighed) + pull
            root = np.linalg.cholesky(whole).T
            target = np.linalg.solve(root.T, gradient)
            change[seen] = lsq_linear(root, target, bounds=(lower, upper)).x
        covariance = np.diag(parameters.standard_deviation**2)
        covariance[seen[:, None], seen] = np.linalg.inv(whole)
        return change, covariance


@dataclass(frozen=True, kw_only=True)
class Identification:
    """Options of identification."""

    steps: int = 6
    """Of Gauss-Newton."""
    linearised: tuple[int, ...] = (0, 1, 3, 5)
    """Steps that compute sensitivities anew; the others keep the last. The last step does, for the
    covariance there."""

    def of_tool(self, step: int) -> bool:
        """The tool's sensitivities are needed: not in the first step, if the second has its own."""
        return step > 0 or self.steps == 1 or 1 not in self.linearised


@dataclass(frozen=True, kw_only=True, eq=False)
class IdentifiedParameters:
    """Parameters with their posterior covariance, and what they leave of the cuts."""

    theta: Array
    covariance: Array
    """(m, m), of the linearised model at theta."""
    held_out: Array
    within: Array
    """(c,), root mean square of the tool's residual of each cut, left out and included: [m] of a
    tracker, of an IMU over its white noise. A single cut cannot be left out: NaN."""
    torque: Array
    """(c, 6) [N m], root mean square of the torque residual of each cut."""


def parameters_of(design: RobotDesign) -> Parameters:
    """All unknown parameters of individuals of a design."""
    of_tool = tool_blocks(len(structure_hinges(design.model)), design.hysteresis)
    return Parameters((*FRICTION, MASS, *of_tool))


def identify(
    design: RobotDesign,
    cuts: Sequence[MeasuredCut],
    cfg: Identification = Identification(),
    progress: Callable[[], None] = lambda: None,
    *,
    sensor: ToolSensor | Sequence[ToolSensor] = TRACKER,
) -> IdentifiedParameters:
    """Identify an individual from recorded cuts.

    sensor: of the tool, one for all cuts or one for each. What is unknown of a sensor itself is
    identified too, and left out of the result.

    The first step moves friction and masses alone, by torque: what the tool does before the motors
    move as they should would be taken for springs.
    """
    numbers = [cut.scan.number for cut in cuts if cut.scan is not None]
    if len(set(numbers)) < len(numbers):
        raise ValueError("a contour was scanned twice: the cuts of one sheet are identified from")
    sensors = [sensor] * len(cuts) if isinstance(sensor, ToolSensor) else list(sensor)
    kinds = list({id(kind): kind for kind in sensors}.values())
    of_robot = parameters_of(design)
    own = {b.name: b for cut, kind in zip(cuts, sensors, strict=True) for b in kind.own(cut)}
    parameters = Parameters((*of_robot.blocks, *own.values()))
    each = [Against(design, parameters, cut, kind) for cut, kind in zip(cuts, sensors, strict=True)]
    torque_noise = TORQUE_NOISE * design.model.drives.torque_limit
    least = np.append(torque_noise, [kind.noise for kind in kinds])
    of_torque = np.full(N_AXES, CORRELATION)
    correlation = np.append(of_torque, [kind.correlation for kind in kinds])
    solving = Solving(parameters, parameters.mean, least, correlation)
    found, last = list[Compared](), solving
    covariance = np.diag(parameters.standard_deviation**2)
    with ThreadPoolExecutor(min(cores(), _AT_ONCE)) as pool:
        for step in range(cfg.steps):
            anew = step in cfg.linearised
            known = [None] * len(each) if anew else [cut.columns for cut in found]
            found = list[Compared]()
            tool = cfg.of_tool(step)
            for cut in pool.map(
                compared, each, repeat(solving.theta), known, repeat(kinds), repeat(tool)
            ):
                found.append(cut)
                progress()
            groups, last = together(found), solving
            change, covariance = solving.solve(groups[:N_AXES] if step == 0 else groups)
            solving = replace(solving, theta=solving.theta + change)
    whole, without = last.solve(together(found))[0], []
    for cut in found:
        others = together([other for other in found if other is not cut])
        without.append(cut.tool_residual(last.solve(others)[0]) if others else np.nan)
    residuals = [cut.residuals for cut in found]
    torque = [np.mean(each.torque[each.moving] ** 2, axis=0) for each in residuals]
    m = of_robot.size
    return IdentifiedParameters(
        theta=solving.theta[:m],
        covariance=covariance[:m, :m],
        held_out=np.array(without),
        within=np.array([cut.tool_residual(whole) for cut in found]),
        torque=np.sqrt(torque),
    )
