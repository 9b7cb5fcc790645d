"""First run of a program by a twin: targets learned inside it, and the error to expect.

The error is predicted as that of a first cut, by runs of the program. Factors and interval were
fitted to corrections by samples of the motors: the check holds, an interval is not given.
"""

from dataclasses import replace

import numpy as np

from ...robot.model import RobotModel
from ...twin.correction import twin_error
from ...twin.first_cut import FirstCut
from ...twin.prediction import Corrected, objection, predicted
from ...twin.simulation import motor_path
from ...twin.twin import Twin
from .target_learning import Model, learned_in
from .virtual_run import PlannedProgram


def first_run(program: PlannedProgram, twin: Twin) -> tuple[FirstCut, RobotModel]:
    """The twin with the displacement (N, 3) [m] for the program's first run, and its robot.

    Raises TwinError for a cut of another robot.
    """
    experiment, cut = program.experiment, program.experiment.cut
    twin.check(cut)
    design, reference = twin.design_with(cut.payload), experiment.loaded.reference
    each = (twin.individual, *twin.around)
    robot, *others = [design.load(one, reference).model for one in each]
    learned = learned_in(program, robot)
    none, moved = np.zeros((program.ends[-1], 3)), program.offsets(learned)
    tried = [(none, robot), (moved, robot), *((moved, other) for other in others)]
    runs = Model(program, robot).runs(tried)
    rms = [twin_error(experiment, run, (a.run_time, a.plan_time)) for run, a in runs]
    expected = predicted(rms[0], rms[1], np.array(rms[2:]), twin.evidence)
    prediction = replace(expected, calibrated=False)
    reason = objection(prediction)
    corrected = Corrected(
        correction=learned if reason is None else np.zeros_like(learned),
        learned=learned,
        motor_path=motor_path(runs[int(reason is None)][0]),
        prediction=prediction,
        reason=reason,
    )
    return FirstCut(twin, corrected), robot
