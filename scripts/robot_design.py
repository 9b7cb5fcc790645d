"""Design of the heuristic law from learning data of a robot. Thesis (9.11), (9.12)."""

from dataclasses import dataclass, replace

import numpy as np

from armside.ilc.analysis.proposal import Proposal, design_for
from armside.ilc.identification.first_order import FirstOrderModel
from armside.ilc.identification.learning_data import LearningRecord, identify
from armside.sim.laser.experiment import Experiment, iterate
from armside.sim.robot.virtual_robot import LOG_PERIOD

from .commands.laser import LaserCfg, learning_law, prepare
from .laser_options import THESIS

SPEEDS = (30.0, 40.0, 60.0)
"""[mm/s], of the identification, as in the thesis."""
CUTOFFS = (10.0, 15.0, 20.0, 22.5)
"""[Hz], from the default of the thesis to the highest it tried."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A design for all motors of a robot, and the model it was made for."""

    model: FirstOrderModel
    proposal: Proposal


def asked_for(cfg: LaserCfg, seed: int) -> Asked:
    """The design with the highest cutoff that is fast enough for one model of all motors.

    The model is identified from learning with the design of the thesis at three speeds.
    """
    model = identified(cfg, seed)
    return Asked(model=model, proposal=design_for(model.system, CUTOFFS))


def identified(cfg: LaserCfg, seed: int) -> FirstOrderModel:
    """T_u of all motors together, from learning with the design of the thesis at `SPEEDS`."""
    records = [_learned(replace(cfg, speed=speed, **THESIS._asdict()), seed) for speed in SPEEDS]
    return identify(records, LOG_PERIOD)


def _learned(cfg: LaserCfg, seed: int) -> LearningRecord:
    experiment = prepare(cfg, seed)
    first, *_, last = (it.trial for it in iterate(experiment, learning_law(cfg), cfg.iterations))
    return LearningRecord(last.correction, first.error, last.error, _motion_end(experiment))


def _motion_end(experiment: Experiment) -> int:
    """The first sample at which the reference rests again."""
    motion = experiment.motion
    return int(np.searchsorted(motion.time, motion.rest_before + motion.timing.duration))
