"""The controller's model of the motors, and its criterion of a design.

The model is T_u of one motor: thesis (9.12) on the large robot, and on another robot what (9.11)
identifies from two updates of the nominal one. The tool is not in it: a design whose motors
converge may still leave it worse.
"""

from functools import lru_cache

from armside.ilc.analysis.criterion import frequency_grid, heuristic_criterion
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.identification.first_order_lag import LearningRecord, identify
from armside.ilc.models.system import System

from ..cell import Cell
from ..laser.design import Design, default_design
from ..laser.experiment import prepare
from ..laser.learning_task import SERVO
from ..laser.loop import iterate
from ..laser.measures import MotorAngles
from ..laser.specification import Cut
from ..robot.virtual_robot import LOG_PERIOD

UPDATES = 2
"""Of the nominal robot, to identify it from. ESTIMATE: the correction has its size after two."""
GRID = frequency_grid(800)
"""[rad/sample]; it finds suprema to 2e-4 of those that `armside learn` prints."""


def motor_model(robot: str | Cell) -> System:
    """T_u of every motor of the nominal robot. Raises ValueError for a robot that cannot cut the
    default circle at its first pose."""
    if robot == "large":
        return SERVO
    experiment = prepare(cut := Cut(robot=robot), seed=0)
    design = MotorAngles(default_design(cut.cell)).prepare(experiment)
    first, *_, last = iterate(experiment, design, UPDATES)
    record = LearningRecord(last.correction, first.error, last.error, experiment.motion_end)
    return identify([record], LOG_PERIOD).system


@lru_cache(maxsize=1024)
def contraction(T_u: System, design: Design) -> float:
    """Criterion (7.5), sup |Q (1 - L T_u)|, the largest of all motors: above 1 they diverge."""
    n = max(len(design.gamma), len(design.delta), len(design.cutoff))
    each = zip(*design.arrays(n).values(), strict=True)
    return max(
        heuristic_criterion(
            T_u, float(gamma), int(delta), ZeroPhaseButterworth(cutoff, LOG_PERIOD), GRID
        ).contraction
        for gamma, delta, cutoff in each
    )
