"""Cuts that a robot is commissioned with, chosen by what they identify.

Candidates are circles and polygons, slow and fast, at poses over the workspace. They are taken one
by one, each kind of contour in turn, of each kind the one that adds most to log det of the
information about all parameters (D-optimal, greedy). So a shorter plan is the beginning of a longer
one, and what no parameter knows of has a chance to show in each kind of motion.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array

from ..cell import TOOL_QUATERNION, ToolPose
from ..laser.experiment import prepare
from ..laser.specification import Cut
from ..motion.contour import Circle, ClosedCurve, hexagon, square
from ..robot.mjcf import N_AXES
from .identification import Identification, parameters_of
from .recordings import MeasuredCut, measured
from .sensitivities import Against
from .simulation import RobotDesign, motor_path, tool_path

_CONTOURS: tuple[tuple[ClosedCurve, float], ...] = (
    (Circle(0.020), 0.080),
    (Circle(0.007), 0.085),
    (hexagon(0.012, 0.0018), 0.030),
    (square(0.030, 0.0045), 0.070),
)
"""Contour and speed [m/s]: slow and fast, smooth and with corners."""
_PLACES = (
    (1.3166, 0.0014, 1.5992),
    (1.8, 0.1, 1.5992),
    (2.2, 0.2, 1.5992),
    (1.5, -0.6, 1.2),
    (1.7, 0.7, 1.9),
    (2.1, -0.5, 1.3),
    (1.3, 0.6, 1.1),
    (1.9, 0.5, 1.1),
)
"""[m], TCP0 in base axes: p1, p2, p3 of thesis (9.3), and five around them."""
CANDIDATES = tuple(
    Cut(pose=ToolPose(place, TOOL_QUATERNION), contour=contour, speed=speed)
    for place in _PLACES
    for contour, speed in _CONTOURS
)
"""Of the large robot."""
_ORDER = (11, 0, 22, 17, 23, 24, 10, 1, 19, 12)
"""The first ten of `chosen`, by number of the candidate: `armside commission --choose`."""
MOST = len(_ORDER)


def plan(count: int) -> tuple[Cut, ...]:
    """The best few cuts. Raises ValueError for a count that is not from 1 to `MOST`."""
    if not 1 <= count <= MOST:
        raise ValueError(f"cuts must be from 1 to {MOST}, got {count}")
    return tuple(CANDIDATES[i] for i in _ORDER[:count])


def recorded(cut: Cut, name: str, seed: int) -> MeasuredCut:
    """Record of an uncorrected cut by the virtual robot. Raises ValueError as `prepare`."""
    experiment = prepare(cut, seed=seed)
    return measured(experiment.plant.run(np.zeros_like(experiment.loaded.reference)), name)


@dataclass(frozen=True)
class Choice:
    """A candidate that was taken, and what it adds."""

    number: int
    gain: float
    """Of log det of the information [nat]."""


def chosen(
    design: RobotDesign,
    count: int = MOST,
    candidates: Sequence[Cut] = CANDIDATES,
    progress: Callable[[], None] = lambda: None,
) -> list[Choice]:
    """The most informative candidates for individuals of a design, in the order they are taken."""
    parameters = parameters_of(design)
    whole = np.diag(parameters.standard_deviation**-2.0)
    each = list[Array]()
    for cut in candidates:
        each.append(_information(design, cut))
        progress()
    taken = list[Choice]()
    for _ in range(count):
        used = [candidates[choice.number].curve for choice in taken]
        rarest = min(used.count(cut.curve) for cut in candidates)
        now = float(np.linalg.slogdet(whole)[1])
        gains = {
            i: float(np.linalg.slogdet(whole + information)[1]) - now
            for i, information in enumerate(each)
            if used.count(candidates[i].curve) == rarest
            and i not in {choice.number for choice in taken}
        }
        best = max(gains, key=lambda i: gains[i])
        taken.append(Choice(best, gains[best]))
        whole = whole + each[best]
    return taken


def _information(design: RobotDesign, cut: Cut) -> Array:
    """Information of a cut about an individual like the design."""
    parameters, cfg = parameters_of(design), Identification()
    reference = prepare(replace(cut, friction_spread=0.0)).loaded.reference
    against = Against(design, parameters, _nominal_run(design, reference))
    _, columns = against.linearised(parameters.mean)
    torque = cfg.correlation * _TORQUE * design.model.drives.torque_limit
    information = np.zeros((parameters.size, parameters.size))
    for axis in range(N_AXES):
        A = columns.torque[against.cut.moving, axis] / torque[axis]
        information += A.T @ A
    A = columns.tool.reshape(-1, parameters.size) / (cfg.correlation * _TOOL)
    return information + A.T @ A


_TORQUE, _TOOL = 2e-3, 1e-5
"""Residuals to expect: of torque over its limit, and of the tool [m]; as with hidden hinges."""


def _nominal_run(design: RobotDesign, reference: Array) -> MeasuredCut:
    parameters = parameters_of(design)
    zero = np.zeros_like(reference)
    twin = parameters.individual(parameters.mean, np.zeros((N_AXES, 4)))
    run = design.run([twin], reference, zero)[0]
    return MeasuredCut(
        name="nominal",
        reference=reference,
        correction=zero,
        motor_angle=motor_path(run),
        motor_torque=run.motor_torque,
        tool=tool_path(run),
    )
