"""Specification of an IMU experiment: robot, motion, sensor and processing. SI units."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np

from armside.arrays import Array

from ..cell import CELLS, Cell
from ..instruments.imu import ImuCfg
from ..motion.about_home import dynamics_of, programs_about
from ..motion.instructions import Program
from ..motion.program_file import read_program
from ..robot.flexibility import Flexibility, variant, without
from ..robot.kinematics_check import cell_model
from ..robot.model import RobotModel
from ..robot_file.find import find_cell
from .predicted_motion import ProcessingCfg

Motion = Literal["simultaneous", "sequential"]
SHORTEST_REST = 3.0  # Record that a power spectrum needs [s]


@dataclass(frozen=True, kw_only=True)
class RobotSetup:
    """Virtual robot with an IMU on its tool."""

    robot: str = "irb1400"
    """Name of a cell, or its robot file."""
    flexibility: Flexibility = Flexibility.FULL
    torque_feedforward: bool = True
    """The servo anticipates the torque of inertia, gravity and friction."""
    imu: ImuCfg = field(default_factory=ImuCfg)

    @property
    def cell(self) -> Cell:
        """Kinematics, limits and motion programs of the robot. Raises as `find_cell`."""
        return find_cell(self.robot)

    @property
    def home(self) -> Array:
        """(n,) [rad], motor angles at which the robot rests."""
        cell = self.cell
        return np.zeros(cell.robot.n_joints) if cell.home is None else np.array(cell.home)

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

    def programs(self, model: RobotModel) -> dict[str, Program]:
        """Motion programs by name: of files, or about home for a robot that has none. Raises
        ValueError where it has some, but none of the motion; ProgramError or OSError for a file."""
        cell, home = self.cell, self.home
        files = cell.programs.get(self.motion, ())
        if self.program is not None:
            files = (self.program,)
        if not files and not cell.programs:
            return programs_about(home, cell.limits, model, self.motion)
        if not files:
            missing = f"motion {self.motion!r} has no program for {self.robot}"
            raise ValueError(f"{missing}. It has: {', '.join(cell.programs)}")
        if self.robot in CELLS:
            return {file.stem: read_program(file) for file in files}
        known = dynamics_of(home, cell.limits, model)
        return {file.stem: read_program(file, len(home), known) for file in files}


@dataclass(frozen=True, kw_only=True)
class RestExperiment(RobotSetup):
    """Robot in its zero pose, or at its home, with its motors off, then on. Thesis 5.1.1."""

    imu: ImuCfg = field(default_factory=lambda: ImuCfg(clock_offset=0.0))
    off: float = 25.0
    """Time with the motors off [s]."""
    on: float = 25.0
    """Time with the motors on [s]."""

    def __post_init__(self) -> None:
        if self.robot != "irb1400" and not len(self.model().brakes):
            raise ValueError(f"motion rest needs brakes, which robot {self.robot} lacks")
        if not min(self.off, self.on) >= SHORTEST_REST:
            raise ValueError(f"off and on must be at least {SHORTEST_REST:g} s for a spectrum")
