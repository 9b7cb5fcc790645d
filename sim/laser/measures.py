"""Measured outputs that a cut is learned from: motor angles, or the tool's path by a sensor.

A `Measure` is set up by the first run, before learning, and then reads every run. Any object with
these methods will do: `learn(cut, measure=...)`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from armside.arrays import Array
from armside.ilc.laws import Heuristic, Law, Simulated
from armside.ilc.measures.norms import two_norm

from ..instruments.imu import ImuCfg
from ..notes import Note
from ..robot.virtual_robot import VirtualRobot
from .design import Design, default_design
from .experiment import Experiment, Pass


class Output(Protocol):
    """A measure after the first run."""

    @property
    def reference(self) -> Array:
        """(N, m), desired output."""
        ...

    @property
    def law(self) -> Law:
        """Default law for its errors."""
        ...

    def __call__(self, run: Pass) -> Array:
        """Output (N, m) of a run."""
        ...

    def size(self, error: Array) -> Array:
        """Sizes of an error (N, m) by which divergence is judged."""
        ...


@runtime_checkable
class Noted(Protocol):
    """An output that has something to say about all of its runs."""

    @property
    def notes(self) -> tuple[Note, ...]: ...


SetUp = Callable[[Pass], Output]
"""Sets a measure up by the first run."""


class Measure(Protocol):
    """An output that can be learned from."""

    @property
    def imu(self) -> ImuCfg | None:
        """Unit that it needs at the tool."""
        ...

    def prepare(self, experiment: Experiment) -> SetUp:
        """Everything before the first run. Raises ValueError for a robot it cannot serve."""
        ...


@dataclass(frozen=True)
class MotorAngles:
    """Motor angles by the encoders: learning of the thesis."""

    design: Design | None = None
    """Design of the heuristic law; the robot's default if None."""
    target: Array | None = None
    """(N, n) [rad], arm side, motor angles to learn, such as a twin's; the reference if None."""

    simulated: bool = False
    """Between runs the design learns on the controller's nominal robot: `laws.simulated`."""

    imu = None

    def prepare(self, experiment: Experiment) -> SetUp:
        design = self.design or default_design(experiment.cut.cell)
        reference = experiment.loaded.reference if self.target is None else self.target
        law = _on_nominal(experiment, reference, design.law) if self.simulated else design.law
        law.check(*reference.shape)
        return lambda first: _MotorOutput(reference, law)


def _on_nominal(experiment: Experiment, reference: Array, law: Heuristic) -> Simulated:
    """Law on the nominal robot without noise, whose motors are to follow `reference`."""
    nominal = VirtualRobot(experiment.nominal).load(experiment.loaded.reference)
    gear = np.abs(experiment.nominal.drives.gear).tolist()
    return Simulated(
        simulation=lambda correction: reference - nominal.run(correction).motor_angle,
        law=law,
        Q_d=law.Q,
        weight=tuple(gear),
    )


@dataclass(frozen=True)
class _MotorOutput:
    reference: Array
    law: Law

    def __call__(self, run: Pass) -> Array:
        return run.recording.motor_angle

    def size(self, error: Array) -> Array:
        return two_norm(error)
