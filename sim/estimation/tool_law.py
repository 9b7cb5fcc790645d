"""Learning laws for errors of the tool's path, built on the response of the arm along it."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic, Law
from armside.ilc.laws.first_order import FirstOrderLaw
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse
from armside.ilc.laws.norm_optimal import RecordOptimal
from armside.ilc.laws.wrappers import Guarded, JointSpace

from ..robot.virtual_robot import LOG_PERIOD
from .arm_plant import PathPlants

CUTOFF = 13.0
"""Least cutoff of Q [Hz] where none is given: corners need it, and models of springs in series hold
up to there."""
STIFFEST = 20.0
"""Largest pass band by the arm's lowest mode [Hz], as of learning from the motors' angles."""
HARD, OF_HARD = 2.0, 25.0
"""Excitation from which a motion is hard, and the pass band [Hz] there: corners and stops need it,
and deflections are large beside all that an identified model lacks. Chosen at seeds 0 to 2, on
tasks that are not those of the claim, whose seeds count from 200."""
ROTATION_WEIGHT = 0.1
"""[m]: an orientation error of 1 mrad counts as a position error of 0.1 mm."""
LIMIT = 0.02
"""Largest displacement of the tool by the correction of each axis [m]."""


class ToolLawKind(Enum):
    """Law for errors of the tool."""

    INVERSE = "inverse"
    NORM_OPTIMAL = "norm-optimal"
    HEURISTIC = "heuristic"


@dataclass(frozen=True, kw_only=True)
class ToolLaw:
    """Options of a law for errors (N, 6) of the tool's path [m], [rad]."""

    kind: ToolLawKind = ToolLawKind.INVERSE
    gamma: float = 0.9
    """Learning gain."""
    cutoff: float | None = None
    """Of Q [Hz]; `pass_band` of the programmed contour and the arm if None."""
    delta: int = 3
    """Time shift of the heuristic law [samples]."""
    guarded: bool = True
    """Reduce the gain when errors no longer fall."""

    def band(self, plants: PathPlants, turn_rate: float) -> float:
        """Cutoff of Q [Hz] on the arm along a path."""
        if self.cutoff is not None:
            return self.cutoff
        return pass_band(turn_rate, plants.lowest_mode, plants.excitation)

    def along(self, plants: PathPlants, turn_rate: float, *, rotations: bool = True) -> Law:
        """The law on the arm along a path. Raises ValueError for design variables out of range.

        The inverse fades from place to place, other kinds are built on the plant in the middle.

        Args:
            turn_rate: of the programmed contour [turns/s].
            rotations: errors have orientations, not positions alone.
        """
        cutoff = self.band(plants, turn_rate)
        rotation = ROTATION_WEIGHT if rotations else 0.0
        weight = (1.0, 1.0, 1.0, rotation, rotation, rotation)
        low_pass = ZeroPhaseButterworth(cutoff, LOG_PERIOD)
        plant = plants.middle
        chosen: FirstOrderLaw
        if self.kind is ToolLawKind.INVERSE:
            inverses = [
                RegularisedInverse(
                    G=each,
                    sample_time=LOG_PERIOD,
                    cutoff=cutoff,
                    gamma=self.gamma,
                    output_weight=weight,
                    input_size=tuple(each.input_size.tolist()),
                    limit=LIMIT,
                )
                for each in plants.plants
            ]
            chosen = ScheduledInverse(laws=tuple(inverses), weights=plants.weights)
        elif self.kind is ToolLawKind.NORM_OPTIMAL:
            size = tuple(plant.input_size.tolist())
            chosen = RecordOptimal(G=plant, F=low_pass, output_weight=weight, input_size=size)
        else:
            J = plant.arm.tool_jacobian[:, plant.arm.axes] * np.sign(weight)[:, None]
            inverse = np.asarray(np.linalg.pinv(J), dtype=np.float64)
            heuristic = Heuristic(Q=low_pass, gamma=self.gamma, delta=self.delta)
            chosen = JointSpace(law=heuristic, inverse=inverse)
        return Guarded(law=chosen, weight=weight) if self.guarded else chosen


def pass_band(turn_rate: float, lowest_mode: float = 0.0, excitation: float = 0.0) -> float:
    """Cutoff of Q [Hz] for a contour with `turn_rate` turns a second.

    `CUTOFF`. Of a fast contour the third harmonic has to pass, which it does with a gain of three
    quarters at four times the first; above 15 Hz models identified from one run no longer hold,
    unless that run was a hard one.
    An arm whose lowest identified mode is higher is learned up to it, at most to `STIFFEST`: its
    model holds there, and drives leave errors that a soft arm's law must not touch.
    """
    if excitation >= HARD:
        return OF_HARD
    by_contour = min(max(CUTOFF, 4.0 * turn_rate), 15.0)
    return max(by_contour, min(lowest_mode, STIFFEST))
