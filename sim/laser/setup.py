"""Robot individual that cuts: its cell and state, its load, limits and sensors."""

from dataclasses import dataclass, field
from pathlib import Path

from armside.kinematics.robot_file import GearTerm

from ..cell import Cell, ToolPose, pose
from ..cell_file import find_cell
from ..instruments.imu import ImuCfg
from ..motion.timing import PathLimits
from ..robot.effects import Effect
from ..robot.individual import Individual
from ..robot.spread import Drawn


@dataclass(frozen=True, kw_only=True)
class Setup:
    """Robot individual with its tool at a pose of its cell. SI units."""

    robot: str | Cell = "large"
    """Name of a cell, its robot file, or a cell of one's own."""
    model: Path | None = None
    """MJCF in place of the cell's."""
    pose: str | ToolPose = "p1"
    """Centre of the contour or part and orientation of the tool: a named pose of the cell, or any.
    """
    limits: PathLimits = field(default_factory=PathLimits)
    """Limits of the controller for acceleration and jerk along the path."""
    payload: float | None = None
    """Mass of the tool [kg]; that of the model if None."""
    payload_known: bool = True
    """The controller knows the payload."""
    friction_spread: float = 0.02
    """Friction of each axis is uniform within +- this fraction of the nominal."""
    individual: Individual | Drawn | int | None = None
    """Parameters of the individual, or the seed they are drawn with; None: friction only. A bare
    seed stands for the individuals of thesis chapter 9: `Spread()`."""
    friction_drift: float = 0.0
    """Change of Coulomb and static friction since the robot was commissioned, relative."""
    temperature: float | None = None
    """Of the gears [deg C]; that of the model if None."""
    friction_feedforward: float | None = None
    """Fraction of friction that the controller feeds forward; that of the model if None."""
    without: tuple[Effect, ...] = ()
    """Effects of gears and drives that are left out, for ablations."""
    imu: ImuCfg | None = None
    """Unit at the tool."""
    gear_error: tuple[GearTerm, ...] = ()
    """Transmission error of this individual that the controller knows: motors are asked for r -
    epsilon(r), so that the gears' outputs follow r, and estimators add epsilon to motor angles."""

    def __post_init__(self) -> None:
        for effect in self.without:
            if not isinstance(effect, Effect):
                names = ", ".join(str(each) for each in Effect)
                raise ValueError(f"without takes effects, got {effect!r}. Effects: {names}")

    @property
    def cell(self) -> Cell:
        """The robot's cell. Raises ValueError for an unknown name or a wrong robot file."""
        return self.robot if isinstance(self.robot, Cell) else find_cell(self.robot)

    @property
    def tool_pose(self) -> ToolPose:
        """Centre and orientation. Raises ValueError for an unknown name."""
        return pose(self.pose, self.cell.poses) if isinstance(self.pose, str) else self.pose
