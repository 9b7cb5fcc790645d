"""What an analysis of gears found of a robot's true errors."""

from typing import NamedTuple

import numpy as np

from armside.arrays import Array
from armside.sim.gears.analysis import GearAnalysis
from armside.sim.gears.transmission import Term
from armside.sim.robot.drives import GearError

SEEN = 10e-6
"""[m], of an axis's contribution at the tool from which on its error must be found."""
NEAR = 2.0
"""Periods per turn by which an order may be off and still be that of the gear."""
PER_MOTOR_TURN = 2
"""Place of the order of one period per motor turn in a robot's file."""


class Discrepancy(NamedTuple):
    """One axis that moves the tool: contribution [m], and what was found of it."""

    joint: int
    """From 1."""
    contribution: float
    """[m], amplitude of the tool."""
    amplitude: float
    """Found over true, less one; NaN where the axis was missed."""
    phase: float
    """Found less true at the middle of the travel [rad]; NaN where the axis was missed."""


def discrepancies(done: GearAnalysis, truth: GearError) -> tuple[Discrepancy, ...]:
    """Every axis whose error of one period per motor turn moves the tool by more than `SEEN`."""
    moved = [np.linalg.norm(one.motion.point_jacobian(one.target), axis=1) for one in done.aligned]
    arm = np.sqrt((np.concatenate(moved) ** 2).mean(axis=0))
    middle = np.concatenate([one.motion.phi for one in done.aligned]).mean(axis=0)
    contribution = arm * np.abs(truth.amplitude[:, PER_MOTOR_TURN])
    terms = [] if done.found is None else done.found.terms
    return tuple(
        _discrepancy(j, float(contribution[j]), terms, truth, middle)
        for j in np.flatnonzero(contribution > SEEN).tolist()
    )


def _discrepancy(
    j: int, contribution: float, terms: list[Term], truth: GearError, middle: Array
) -> Discrepancy:
    amplitude, order, phase = (
        float(part[j, PER_MOTOR_TURN]) for part in (truth.amplitude, truth.order, truth.phase)
    )
    own = [term for term in terms if term.joint == j + 1 and abs(term.order - order) < NEAR]
    if not own:
        return Discrepancy(j + 1, contribution, np.nan, np.nan)
    term = min(own, key=lambda term: abs(term.order - order))
    off = term.phase - phase + (term.order - order) * middle[j]
    off = (off + np.pi) % (2.0 * np.pi) - np.pi
    return Discrepancy(j + 1, contribution, term.amplitude / amplitude - 1.0, float(off))
