"""Identification of a twin: regularised Gauss-Newton on torque and tool, by turns with simulation.

    minimise sum_i |torque residual_i / s_i|^2 + |tool residual / s|^2 + |(theta - mean) / prior|^2

The scales s follow from the residuals themselves: what a model does not explain lasts for many
samples and must not count as if it were noise.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import repeat

import numpy as np

from armside.arrays import Array

from ..robot.individual import structure_hinges
from ..robot.mjcf import N_AXES
from ..robot.run import cores
from .normal_equations import Compared, Solving, compared, held_out, together
from .parameters import FRICTION, MASS, Parameters, tool_blocks
from .recordings import MeasuredCut
from .sensitivities import Against, Residuals
from .simulation import RobotDesign
from .tool_sensor import TRACKER, ToolSensor

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
