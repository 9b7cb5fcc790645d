"""Design of the heuristic law from learning data of a robot. Thesis (9.11), (9.12)."""

from dataclasses import dataclass, replace

from armside.ilc.analysis.proposal import Proposal, design_for
from armside.ilc.identification.first_order_lag import FirstOrderModel, LearningRecord, identify

from ..robot.virtual_robot import LOG_PERIOD
from .design import THESIS
from .experiment import prepare
from .loop import iterate
from .measures import MotorAngles
from .specification import Cut

SPEEDS = (0.030, 0.040, 0.060)
"""[m/s], of the identification, as in the thesis."""
CUTOFFS = (10.0, 15.0, 20.0, 22.5)
"""[Hz], from the default of the thesis to the highest it tried."""


@dataclass(frozen=True, kw_only=True)
class DesignFromData:
    """A design for all motors of a robot, and the model it was made for."""

    model: FirstOrderModel
    proposal: Proposal


def design_from_data(cut: Cut, seed: int) -> DesignFromData:
    """Design with the highest cutoff that contracts fast enough for one model of all motors.

    T_u of all motors together is identified from learning with the design of the thesis at three
    speeds.
    """
    records = list[LearningRecord]()
    for speed in SPEEDS:
        experiment = prepare(replace(cut, speed=speed), seed=seed)
        first, *_, last = iterate(experiment, MotorAngles(THESIS).prepare(experiment), 5)
        end = experiment.motion_end
        records.append(LearningRecord(last.correction, first.error, last.error, end))
    model = identify(records, LOG_PERIOD)
    return DesignFromData(model=model, proposal=design_for(model.system, CUTOFFS))
