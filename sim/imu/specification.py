"""Specification of an IMU experiment: robot, motion, sensor and processing. SI units."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import mujoco

from ..cell import CELLS, Cell
from ..instruments.imu import ImuCfg
from ..robot.cell_model import cell_model
from ..robot.flexibility import Flexibility, variant, without
from ..robot.model import RobotModel
from .processing import ProcessingCfg

RobotName = Literal["irb1400", "large"]
Motion = Literal["simultaneous", "sequential"]
SHORTEST_REST = 3.0  # Record that a power spectrum needs [s]


@dataclass(frozen=True, kw_only=True)
class RobotSetup:
    """Virtual robot with an IMU on its tool."""

    robot: RobotName = "irb1400"
    flexibility: Flexibility = Flexibility.FULL
    torque_feedforward: bool = True
    """The servo anticipates the torque of inertia, gravity and friction."""
    imu: ImuCfg = field(default_factory=ImuCfg)

    @property
    def cell(self) -> Cell:
        """Kinematics, limits and motion programs of the robot."""
        return CELLS[self.robot]

    def spec(self) -> mujoco.MjSpec:
        """MJCF of the robot with its flexibility, parsed."""
        spec = mujoco.MjSpec.from_file(str(self.cell.xml))
        without(spec, self.flexibility)
        return spec

    def model(self) -> RobotModel:
        """Virtual hardware, compiled."""
        model = cell_model(self.cell, variant(self.cell.xml, self.flexibility))
        if self.torque_feedforward:
            return model
        return replace(model, drives=replace(model.drives, torque_feedforward=0.0))


@dataclass(frozen=True, kw_only=True)
class ImuExperiment(RobotSetup):
    """Motion of a robot with an IMU, and the processing that compares it with its prediction."""

    motion: Motion = "simultaneous"
    """All motors at once, or one at a time in two programs."""
    program: Path | None = None
    """Motion program (TOML) in place of the motion's own."""
    processing: ProcessingCfg = field(default_factory=ProcessingCfg)

    def __post_init__(self) -> None:
        nyquist, cutoff = 0.5 * self.imu.rate, self.processing.cutoff
        if cutoff >= nyquist:
            raise ValueError(f"cutoff must be below {nyquist:g} Hz, got {cutoff:g}")

    @property
    def programs(self) -> tuple[Path, ...]:
        """Files of the motion programs. Raises ValueError where the robot lacks the motion."""
        if self.program is not None:
            return (self.program,)
        programs = self.cell.programs
        if self.motion not in programs:
            missing = f"motion {self.motion!r} has no program for {self.robot}"
            raise ValueError(f"{missing}. It has: {', '.join(programs)}")
        return programs[self.motion]


@dataclass(frozen=True, kw_only=True)
class RestExperiment(RobotSetup):
    """Robot in its zero pose with its motors off, then on. Thesis 5.1.1."""

    imu: ImuCfg = field(default_factory=lambda: ImuCfg(clock_offset=0.0))
    off: float = 25.0
    """Time with the motors off [s]."""
    on: float = 25.0
    """Time with the motors on [s]."""

    def __post_init__(self) -> None:
        if self.robot != "irb1400":
            raise ValueError(f"motion rest needs brakes, which robot {self.robot} lacks")
        if not min(self.off, self.on) >= SHORTEST_REST:
            raise ValueError(f"off and on must be at least {SHORTEST_REST:g} s for a spectrum")
