"""The tool's path over a whole part as measured output.

A part is a long way, along which estimate and law follow the pose. Where they cannot (a robot with
closed chains, a part of millimetres) springs are identified from the beginning of the first run,
which is as long as a single cut, and the law's plant is that of the middle of the part.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..estimation.arm_plant import ArmPlant
from ..estimation.linearised_arm import linearised
from ..estimation.nominal import NominalArm
from ..instruments.imu import ImuSamples
from ..laser.experiment import Experiment, Pass
from ..laser.tool_measure import Source, ToolOutput
from ..laser.way_measure import PathAlongWay, WayOutput
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD

EXCERPT = 4.0
"""Length of the record that springs are identified from [s]: a rapid move and first contours."""


@dataclass(frozen=True, kw_only=True)
class PartToolPath(PathAlongWay):
    """Path of the tool over a part, from rest."""

    def commissioned(self, experiment: Experiment, arm: NominalArm, first: Pass) -> ToolOutput:
        """The measure set up by the beginning of a run. Raises ImuError as `ToolPath` does."""
        record = first if self.follows(experiment, arm) else beginning(first, EXCERPT)
        output = super().commissioned(experiment, arm, record)
        if isinstance(output, WayOutput):
            return output
        away = np.linalg.norm(experiment.programmed - _middle(experiment), axis=1)
        phi = experiment.loaded.reference[int(away.argmin())]
        springs = output.known.springs if self.commissioning.law_identified else None
        on = arm if springs is None else springs.on(arm)
        plant = ArmPlant(robot=experiment.nominal, arm=linearised(on, phi), period=LOG_PERIOD)
        return replace(output, known=replace(output.known, plant=plant))


def _middle(experiment: Experiment) -> np.ndarray:
    tool = experiment.programmed
    return 0.5 * (tool.min(axis=0) + tool.max(axis=0))


MEASURES = {source.value: PartToolPath(source=source) for source in Source}
"""By name."""


def beginning(run: Pass, seconds: float) -> Pass:
    """The first seconds of a run, the ground truth apart."""
    log, imu = run.recording, run.imu
    n = int(np.searchsorted(log.time, seconds))
    names = ("time", "reference", "correction", "motor_angle", "motor_torque")
    short: Recording = replace(log, **{name: getattr(log, name)[:n] for name in names})
    if imu is not None:
        imu = _first(imu, int(np.searchsorted(imu.time - imu.time[0], seconds)))
    return replace(run, recording=short, imu=imu)


def _first(samples: ImuSamples, n: int) -> ImuSamples:
    names = ("time", "acceleration", "angular_velocity")
    names = (*names, "acceleration_clipped", "angular_velocity_clipped")
    return replace(samples, **{name: getattr(samples, name)[:n] for name in names})
