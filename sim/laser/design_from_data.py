"""Design of the heuristic law from learning data of a robot. Thesis (9.11), (9.12)."""

from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.proposal import Proposal, propose
from armside.ilc.identification.first_order import FirstOrder, fit_first_order

from ..robot.virtual_robot import LOG_PERIOD
from .design import THESIS
from .experiment import prepare
from .learning import iterate
from .measures import MotorAngles
from .specification import Cut

SPEEDS = (0.030, 0.040, 0.060)
"""[m/s], of the identification, as in the thesis."""
CUTOFFS = (10.0, 15.0, 20.0, 22.5)
"""[Hz], from the default of the thesis to the highest it tried."""
FAST_ENOUGH = 0.5
"""Contraction factor that a design must reach."""


@dataclass(frozen=True, kw_only=True)
class DesignFromData:
    """A design for all motors of a robot, and the model it was made for."""

    model: FirstOrder
    proposal: Proposal


def design_from_data(cut: Cut, seed: int) -> DesignFromData:
    """Design with the highest cutoff that is fast enough for one model of all motors.

    T_u of all motors together is identified from u_5 and y_5 - y_0, summed over three speeds, of
    learning with the design of the thesis. Thesis (9.11), (9.12).
    """
    pairs = [_learned(replace(cut, speed=speed), seed) for speed in SPEEDS]
    # At rest friction holds a motor wherever it stopped: that is no dynamics.
    n = min(len(u) for u, _ in pairs)
    u, y = (np.sum([pair[i][:n] for pair in pairs], axis=0) for i in range(2))
    model = fit_first_order(u, y, LOG_PERIOD)
    found = [propose(model.system, cutoff, deltas=range(13)) for cutoff in CUTOFFS]
    quick = [proposal for proposal in found if proposal.contraction <= FAST_ENOUGH]
    return DesignFromData(model=model, proposal=quick[-1] if quick else found[0])


def _learned(cut: Cut, seed: int) -> tuple[Array, Array]:
    """u_5 and y_5 - y_0 until the end of the motion, (N, 6) each [rad]."""
    experiment = prepare(cut, seed=seed)
    first, *_, last = iterate(experiment, MotorAngles(THESIS).prepare(experiment), 5)
    n = experiment.motion_end
    return last.correction[:n], (first.error - last.error)[:n]
