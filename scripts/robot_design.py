"""Design of the heuristic law from learning data of a robot. Thesis (9.11), (9.12)."""

from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.proposal import Proposal, propose
from armside.ilc.identification.first_order import FirstOrder, fit_first_order
from armside.sim.laser.experiment import Experiment, Iteration, iterate
from armside.sim.robot.virtual_robot import LOG_PERIOD

from .commands.laser import LaserCfg, learning_law, prepare
from .laser_options import THESIS

SPEEDS = (30.0, 40.0, 60.0)
"""[mm/s], of the identification, as in the thesis."""
CUTOFFS = (10.0, 15.0, 20.0, 22.5)
"""[Hz], from the default of the thesis to the highest it tried."""
FAST_ENOUGH = 0.5
"""Contraction by which a design must shrink the distance to its limit in every iteration."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A design for all motors of a robot, and the model it was made for."""

    model: FirstOrder
    proposal: Proposal


def asked_for(cfg: LaserCfg, seed: int) -> Asked:
    """The design with the highest cutoff that is fast enough for one model of all motors.

    The model is identified from learning with the design of the thesis at three speeds.
    """
    model = identified(cfg, seed)
    found = [propose(model.system, cutoff, deltas=range(13)) for cutoff in CUTOFFS]
    quick = [proposal for proposal in found if proposal.contraction <= FAST_ENOUGH]
    return Asked(model=model, proposal=quick[-1] if quick else found[0])


def identified(cfg: LaserCfg, seed: int) -> FirstOrder:
    """T_u of all motors together, from u_5 and y_5 - y_0 summed over the speeds."""
    pairs = [_learned(replace(cfg, speed=speed, **THESIS._asdict()), seed) for speed in SPEEDS]
    # At rest friction holds a motor wherever it stopped: that is no dynamics.
    n = min(len(u) for u, _ in pairs)
    u, y = (np.sum([pair[i][:n] for pair in pairs], axis=0) for i in range(2))
    return fit_first_order(u, y, LOG_PERIOD)


def _learned(cfg: LaserCfg, seed: int) -> tuple[Array, Array]:
    """u_5 and y_5 - y_0 until the end of the motion, (N, 6) each [rad]."""
    experiment = prepare(cfg, seed)
    iterations = list(iterate(experiment, learning_law(cfg), cfg.iterations))
    n = _motion_end(experiment)
    return iterations[-1].trial.correction[:n], _moved(iterations)[:n]


def _moved(iterations: list[Iteration]) -> Array:
    return iterations[0].trial.error - iterations[-1].trial.error


def _motion_end(experiment: Experiment) -> int:
    """The first sample at which the reference rests again."""
    motion = experiment.motion
    return int(np.searchsorted(motion.time, motion.rest_before + motion.timing.duration))
