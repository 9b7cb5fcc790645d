"""Motion instructions in the manner of RAPID, as data in SI units."""

from dataclasses import dataclass

import numpy as np


class ProgramError(ValueError):
    """A program that cannot be read or run; the message names file, line and reason."""


@dataclass(frozen=True, kw_only=True)
class Target:
    """End of a move: motor angles, or a tool pose."""

    motors: tuple[float, ...] | None = None
    """(n,) [rad], arm side."""
    position: tuple[float, float, float] | None = None
    """[m], TCP0 in base axes."""
    quaternion: tuple[float, float, float, float] | None = None
    """Base to tool; None keeps the orientation."""
    near: tuple[float, ...] | None = None
    """(n,) [rad]: MoveJ takes the solution for a pose that is nearest to these motor angles, or to
    its start if None."""

    def __post_init__(self) -> None:
        if (self.motors is None) == (self.position is None):
            raise ValueError("a target has either motors or a position")
        if self.motors is not None and (self.quaternion is not None or self.near is not None):
            raise ValueError("a target with motors has no orientation and no near")
        for name, length in (("position", 3), ("quaternion", 4), ("motors", None), ("near", None)):
            value = getattr(self, name)
            if value is None:
                continue
            if len(value) != (length or len(value)) or not np.isfinite(value).all():
                many = "" if length is None else f"{length} "
                raise ValueError(f"{name} must be {many}finite numbers, got {value}")
        if self.quaternion is not None and np.linalg.norm(self.quaternion) < 1e-9:
            raise ValueError("orientation must not be all zero")


@dataclass(frozen=True, kw_only=True)
class Speed:
    """Speed of the tool along its path, or fraction of the highest speed of the joints."""

    path: float | None = None
    """[m/s]."""
    share: float | None = None
    """Fraction of the highest speed that the joint limits allow on this move, in (0, 1]. The whole
    move is slowed down: its accelerations fall with the square."""

    def __post_init__(self) -> None:
        if (self.path is None) == (self.share is None):
            raise ValueError("a speed is either along the path or a fraction of the joints'")
        if self.path is not None and not (np.isfinite(self.path) and self.path > 0.0):
            raise ValueError(f"speed must be > 0, got {self.path:g} m/s")
        if self.share is not None and not 0.0 < self.share <= 1.0:
            raise ValueError(f"speed must be above 0 and at most 100 %, got {100 * self.share:g} %")


@dataclass(frozen=True, kw_only=True)
class _Move:
    to: Target
    speed: Speed
    zone: float = 0.0
    """Distance from its end at which the move is blended into the next [m]; 0 is a stop point."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.zone) and self.zone >= 0.0):
            raise ValueError(f"zone must be >= 0 m, got {self.zone}")
        if isinstance(self, MoveJ):
            return
        name = type(self).__name__
        if self.to.position is None:
            raise ValueError(f"{name} needs a target with a position; MoveJ goes to motor angles")
        if self.speed.path is None:
            raise ValueError(f"{name} needs a speed along its path; MoveJ can take a percentage")


@dataclass(frozen=True, kw_only=True)
class MoveJ(_Move):
    """Move that is linear in the motor angles."""


@dataclass(frozen=True, kw_only=True)
class MoveL(_Move):
    """Straight line of the tool, rotated at an even rate about one axis."""


@dataclass(frozen=True, kw_only=True)
class MoveC(_Move):
    """Arc of the tool from its start through `via` to the target."""

    via: tuple[float, float, float]
    """[m], base axes."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (len(self.via) == 3 and np.isfinite(self.via).all()):
            raise ValueError(f"via must be 3 finite numbers, got {self.via}")


@dataclass(frozen=True, kw_only=True)
class Wait:
    """Rest for a time."""

    seconds: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.seconds) and self.seconds > 0.0):
            raise ValueError(f"seconds must be > 0, got {self.seconds}")


Move = MoveJ | MoveL | MoveC
Instruction = Move | Wait


@dataclass(frozen=True, kw_only=True)
class Dynamics:
    """Limits of acceleration and jerk of a program."""

    joint_acceleration: tuple[float, ...] = (14.0, 12.0, 12.0, 50.0, 50.0, 70.0)
    """(n,) [rad/s^2]. ESTIMATE for the IRB1400, from its peak torques."""
    path_acceleration: float = 9.0
    """Acceleration of the tool in MoveL and MoveC, along and across its path [m/s^2]. ESTIMATE."""
    jerk_time: float = 0.05
    """Time in which the acceleration rises to its limit [s]; between two stops with limits that
    vary along the path, also changes sign. ESTIMATE."""

    def __post_init__(self) -> None:
        limits = np.array([*self.joint_acceleration, self.path_acceleration, self.jerk_time])
        if not self.joint_acceleration or not (limits > 0.0).all():
            raise ValueError(f"joint accelerations and all limits must be > 0, got {self}")


@dataclass(frozen=True, kw_only=True)
class Program:
    """Instructions from a start at rest; the last one ends at rest."""

    instructions: tuple[Instruction, ...]
    start: tuple[float, ...] = (0.0,) * 6
    """(n,) [rad], motor angles, as many as the robot has."""
    dynamics: Dynamics = Dynamics()
    source: str = "program"
    """Name of the file it was read from."""
    lines: tuple[int, ...] = ()
    """Line of each instruction in that file."""

    def __post_init__(self) -> None:
        if all(isinstance(i, Wait) for i in self.instructions):
            raise ProgramError(f"{self.source}: a program needs at least one move")
        if not self.start or not np.isfinite(self.start).all():
            raise ProgramError(f"{self.source}: start must be finite motor angles")
        targets = [i.to for i in self.instructions if not isinstance(i, Wait)]
        of_motors = [("joint_acceleration", self.dynamics.joint_acceleration)]
        of_motors += [("motors", to.motors) for to in targets if to.motors is not None]
        of_motors += [("near", to.near) for to in targets if to.near is not None]
        for name, given in of_motors:
            if len(given) != len(self.start):
                many = f"{len(self.start)} numbers, one for each motor, got {len(given)}"
                raise ProgramError(f"{self.source}: {name} must be {many}")

    def move(self, index: int) -> Move:
        """The instruction of that index, which is a move."""
        instruction = self.instructions[index]
        assert not isinstance(instruction, Wait)
        return instruction

    def place(self, index: int) -> str:
        """File, line and name of an instruction, for a message."""
        name = type(self.instructions[index]).__name__
        where = f"line {self.lines[index]}" if self.lines else f"instruction {index + 1}"
        return f"{self.source}, {where} ({name})"
