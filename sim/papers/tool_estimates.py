"""Tool position by the estimator of Chen and Tomizuka and by ours, on the strokes of their square.

Both see the same run, each by the unit that it was written for: theirs an accelerometer at 1 kHz on
the clock of the controller, ours an IMU at 100 Hz with a clock of its own.
"""

from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array

from ..estimation.deflection import deflection
from ..estimation.imu_health import ImuError
from ..estimation.nominal import NominalArm, NominalCfg, assumed_arm, nominal_arm
from ..estimation.rigid_motion import rigid_motion
from ..estimation.structure import with_structure
from ..instruments.imu import draw
from ..laser.experiment import Experiment, MountedImu, Pass, prepare
from ..laser.strokes import PERIOD, REST_BEFORE, Strokes, robot_of
from ..laser.tool_measure import ToolPath
from ..robot.kinematics_check import cell_model
from ..robot.spread import Drawn, Spread
from .joint_estimate import ACCELEROMETER, STEP, JointEstimator, signals, tool_positions

STOP = REST_BEFORE + 2.0 * PERIOD, REST_BEFORE + 2.0 * PERIOD + 0.7
"""[s]: third stroke and the stop after it, 3.5 to 4.2 s of the paper's record."""
DOUBLED = 2.0
"""Factor on stiffness and damping of the gears in a wrong model."""
ESTIMATES = ("motor", "smoother", "online", "ours")
"""Motor angles; smoother and causal filter of Chen and Tomizuka; ours."""


@dataclass(frozen=True)
class ToolEstimates:
    """Errors of the estimates in the first run of one individual."""

    robot: str
    individual: int
    geometry: bool = False
    """With the errors of the individual's geometry, and without ours; else it is as designed, or
    calibrated."""

    @property
    def cost(self) -> float:
        """Relative."""
        return 6.0 if self.geometry else 50.0

    def run(self) -> dict[str, Array]:
        """RMS (3,) [m] by estimate, and `NAME doubled` with the wrong model: static part in, over
        `STOP` and over the record; and less its mean at rest before the motion, over the record.
        NaN where ours refuses the run.
        """
        cell = robot_of(self.robot)
        own = Drawn(self.individual, Spread()).of(cell_model(cell, None))
        if not self.geometry:
            own = replace(own, position=np.zeros(()), orientation=np.zeros(()))
        ours = ToolPath(stiffness_error=0.0)
        strokes = Strokes(robot=cell, across_tool=True, individual=own, imu=ours.imu)
        experiment = prepare(strokes, seed=self.individual)
        run = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
        unit = MountedImu(
            draw(ACCELEROMETER, np.random.default_rng([self.individual, 1])),
            np.random.default_rng([self.individual, 2]),
        )
        seen = signals(experiment, replace(run, imu=unit.read(run.recording)))
        truth = run.recording.truth.every(round(STEP / float(run.recording.truth.time[1])))
        found = dict[str, Array]()
        for suffix, factor in (("", 1.0), (" doubled", DOUBLED)):
            cfg = NominalCfg(stiffness=factor, damping=factor)
            theirs = JointEstimator(experiment.nominal, nominal_arm(experiment.nominal, cfg))
            positions = {
                "smoother": tool_positions(theirs.arm, theirs.smoothed(seen)[0]),
                "online": tool_positions(theirs.arm, theirs.filtered(seen)),
            }
            if not self.geometry:
                try:
                    positions["ours"] = our_positions(experiment, ours, run, truth.time, factor)
                except ImuError:
                    positions["ours"] = np.full_like(truth.tool_position, np.nan)
            if not suffix:
                positions["motor"] = tool_positions(theirs.arm, seen.motor_angle)
            for name, position in positions.items():
                found[name + suffix] = _errors(truth.time, position - truth.tool_position)
        return found


def our_positions(
    experiment: Experiment, measure: ToolPath, run: Pass, time: Array, factor: float
) -> Array:
    """(M, 3) [m], base axes, at `time`; factor: on the assumed stiffness and damping of gears.

    Ours is a path from rest. It begins where the assumed arm with the identified springs is at
    rest.
    """
    arm: NominalArm = assumed_arm(with_structure(experiment.nominal), 0.0, 0)
    arm = arm.with_springs(factor * arm.stiffness, factor * arm.damping)
    output = measure.commissioned(experiment, arm, run)
    log = run.recording
    motion = rigid_motion(arm, log.time, log.motor_angle)
    start = deflection(motion, output.known.parameters.springs).angle[:1].copy()
    start[:, arm.axes] += motion.phi[:1]
    path = output.estimated(run).displacement[:, :3] + tool_positions(arm, start)
    return np.column_stack([np.interp(time, log.time, column) for column in path.T])


def _errors(time: Array, error: Array) -> Array:
    stop = (time >= STOP[0]) & (time < STOP[1])
    moved = error - error[time < REST_BEFORE].mean(axis=0)
    each = (error[stop], error, moved)
    return np.array([np.sqrt(np.mean(np.sum(part**2, axis=1))) for part in each])
