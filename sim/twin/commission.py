"""Commissioning of a twin: recorded cuts in, a twin out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .identification import Identification, Identified, identify
from .measured import MeasuredCut
from .plausible import ImplausibleError, check
from .sensors import SENSORS, Measure
from .tool_sensor import Scale
from .twin import Twin, design_of, robot_digest

_OUTLIER = 5.0
"""Held-out residual of a cut over the median of all, above which it is called corrupt. ESTIMATE."""


@dataclass(frozen=True, eq=False)
class Commissioned:
    """A twin, and what its identification says of itself."""

    twin: Twin
    identified: Identified
    measure: Measure


def commission(
    cuts: Sequence[MeasuredCut],
    *,
    robot: str = "large",
    payload: float | None = None,
    measure: Measure = "tracker",
    cfg: Identification = Identification(),
    progress: Callable[[], None] = lambda: None,
) -> Commissioned:
    """Identify the individual that made these cuts.

    Args:
        robot: name of the cell.
        payload: mass of its tool [kg]; that of the robot's file if None.
        measure: sensor of the tool.
        progress: called after each cut of each step.

    Raises:
        ImplausibleError: a recording that cannot be of this robot, or that contradicts the others;
            it is named.
    """
    if not cuts:
        raise ValueError("commissioning needs one recorded cut or more")
    design, sensor = design_of(robot, payload), SENSORS[measure]
    for cut in cuts:
        check(design, cut, sensor)
    found = identify(design, cuts, cfg, progress, sensor=sensor)
    _check_agreement(cuts, found, sensor.scale)
    twin = Twin(
        robot=robot,
        digest=robot_digest(robot),
        payload=payload,
        sensor=measure,
        theta=found.theta,
        covariance=found.covariance,
        held_out=sensor.scale.displacement * found.quality.held_out,
        torque_residual=np.sqrt(np.mean(found.quality.torque**2, axis=0)),
        names=tuple(cut.name for cut in cuts),
    )
    return Commissioned(twin, found, measure)


def _check_agreement(cuts: Sequence[MeasuredCut], found: Identified, scale: Scale) -> None:
    """Raise ImplausibleError for a cut that the twin of the others does not explain at all."""
    left = found.quality.held_out
    worst = int(np.nan_to_num(left).argmax())
    usual = float(np.median(left))
    if len(cuts) > 2 and left[worst] > max(scale.unsuspicious, _OUTLIER * usual):
        much, little = scale.factor * left[worst], scale.factor * usual
        raise ImplausibleError(
            f"{cuts[worst].name} contradicts the other cuts: a twin of those leaves "
            f"{much:.3g} {scale.unit} of the {scale.quantity}, {little:.3g} is usual; leave it "
            "out, or cut it again"
        )
