"""Options of a cut, of `armside laser` and of the robot that cuts, as a person types them."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from cyclopts import Group, Parameter

from armside.kinematics import Robot
from armside.kinematics.robot_file import read_gear_file
from armside.sim.cell import Cell
from armside.sim.laser.design import THESIS, Design, default_design
from armside.sim.robot.effects import TEMPERATURES, Effect
from armside.sim.robot.individual_file import read_individual
from armside.sim.robot.spread import Drawn
from armside.sim.robot_file.find import find_cell

from ..shell.options import (
    PERCENT,
    SEED,
    SOME,
    FileToRead,
    Limits,
    check_limits,
    check_read,
    options,
)

EffectName = Literal["lost-motion", "gear-error", "ripple", "load-friction"]
_GROUP = Group("Robot individual", sort_key=5)
_OF_ROBOT = Parameter(group=_GROUP)
_SEVERAL = Parameter(group=_GROUP, consume_multiple=True)


@options
@dataclass(frozen=True, kw_only=True)
class IndividualCfg:
    """Robot individual and its state."""

    individual: Annotated[int | Path | None, Parameter(group=_GROUP, validator=check_read)] = None
    """Number in the production line, or a TOML file. The robot's own parameters, apart from the
    seed of noise and set-up [default: the design with a friction of its own]."""
    friction_drift: Annotated[float, _OF_ROBOT] = 0.0
    """Change of Coulomb and static friction [%]."""
    temperature: Annotated[float | None, _OF_ROBOT] = None
    """Temperature of the gears, 26 to 80 [deg C] [default: as in the model]."""
    without: Annotated[tuple[EffectName, ...], _SEVERAL] = ()
    """Effects of gears and drives to leave out, for ablations."""

    def __post_init__(self) -> None:
        if isinstance(self.individual, int):
            SEED.check("individual", self.individual)
        Limits(-100.0, 1000.0, "%", above=True).check("friction_drift", self.friction_drift)
        Limits(*TEMPERATURES, "deg C").check("temperature", self.temperature)
        if self.temperature is not None and "load-friction" in self.without:
            raise ValueError("temperature acts through load-friction: do not leave it out")


def robot_state(cfg: IndividualCfg) -> dict[str, Any]:
    """Fields of `armside.sim.laser.Cut` of the options, in SI. Raises ValueError or OSError for a
    file of an individual that cannot be used."""
    chosen = cfg.individual
    drawn = Drawn(chosen) if isinstance(chosen, int) else None
    return {
        "individual": read_individual(chosen) if isinstance(chosen, Path) else drawn,
        "friction_drift": cfg.friction_drift * 1e-2,
        "temperature": cfg.temperature,
        "without": tuple(Effect(name) for name in cfg.without),
    }


@options
@dataclass(frozen=True, kw_only=True)
class KnownGearsCfg(IndividualCfg):
    """Robot individual, and what is known of its gears."""

    gears: Annotated[Path | None, Parameter(group=_GROUP, validator=check_read)] = None
    """File gears.toml of `armside gears`. Of this robot individual: its motors then follow what
    makes the tool right, and the estimate knows its gear error."""


def known_state(cfg: KnownGearsCfg, robot: Robot) -> dict[str, Any]:
    """Likewise, with what is known of the gears. Raises also for a file of another robot."""
    terms = () if cfg.gears is None else read_gear_file(cfg.gears, robot)
    return robot_state(cfg) | {"gear_error": terms}


_BY_ROBOT: Any = None  # until the configuration knows its robot
NOT_NAMED: Any = None
"""Of a measure: motors, though not by name."""
RADIUS = 5.0
"""[mm], of the circle where none is given."""
FRICTION_SPREAD = 2.0
"""[%], of a robot that is no individual."""
OF_ROBOT = {
    "payload": Limits(0.0, 1e4, "kg"),
    "speed": Limits(1e-3, 1e4, "mm/s"),
    "path_acceleration": Limits(1e-3, 1e3, "m/s^2"),
}
"""Values beyond these limits are no machine's, and overflow in what is computed from them."""
OF_CONTOUR = OF_ROBOT | {
    "radius": Limits(0.1, 5e3, "mm"),
    "size": Limits(0.2, 5e3, "mm"),
    "width": Limits(0.2, 5e3, "mm"),
    "corner": Limits(0.1, 5e3, "mm"),
    "position": Limits(-1e5, 1e5, "mm"),
    "quaternion": Limits(-10.0, 10.0),
    "stiffness_error": PERCENT,
    "friction_spread": PERCENT,
}
"""A smaller contour is below what a robot of this size resolves."""
BEAM = Limits(0.01, 100.0, "mm")
"""No laser cuts metal with less."""
OF_LEARNING = {
    "beam": BEAM,
    "iterations": Limits(0),
    "gamma": Limits(high=1e9),
    "cutoff": Limits(high=1e6, unit="Hz"),
    "delta": Limits(high=10**6, unit="samples"),
}
"""`Design` has the smallest values."""
LARGEST_INVERSE_GAIN = 2.0
"""From here on a law that inverts the plant does not converge, however good its model."""
SIX = 6


@options
@dataclass(frozen=True, kw_only=True)
class ContourCfg(KnownGearsCfg):
    """Robot, place and contour of a cut, and what is not known of the robot."""

    robot: str = "large"
    """Robot: large, irb1400, or a robot file (.toml)."""
    model: FileToRead = None
    """MJCF file to use in place of that robot's own."""
    payload: float | None = None
    """Mass of the tool [kg] [default: as in the model]. The controller knows it."""
    pose: str = "p1"
    """Named pose. p1, p2 or p3 of thesis (9.3), or those of the other robot."""
    position: tuple[float, float, float] | None = None
    """X Y Z of TCP0 in base axes [mm]. In place of that pose's position."""
    quaternion: tuple[float, float, float, float] | None = None
    """W X Y Z, orientation from base to tool. In place of that pose's."""
    shape: Literal["circle", "square", "slot", "hexagon"] = "circle"
    """Contour. Corners are rounded."""
    contour: FileToRead = None
    """Closed contour (TOML, DXF) in place of a shape."""
    radius: float = RADIUS
    """Programmed radius of a circle [mm]."""
    size: float | None = None
    """Size of a shape [mm] [default: 20, slot 30]. Side of a square, width across flats of a
    hexagon, length of a slot."""
    width: float | None = None
    """Width of a slot [mm] [default: a third of its length]."""
    corner: float | None = None
    """Corner radius [mm] [default: 15 % of the size]. Of a square, a hexagon, or a contour."""
    lead_in: Literal["arc", "spiral"] = "arc"
    """Lead-in. Along the contour itself, or spiralling outwards from inside it."""
    speed: float = 40.0
    """Programmed speed [mm/s]."""
    plane: Literal["base-xy", "tool"] = "base-xy"
    """Plane. The base x-y plane, or perpendicular to the tool axis."""
    path_acceleration: float = 1.3
    """Limit of acceleration [m/s^2]. Of the controller, along and across the path."""
    stiffness_error: float = 30.0
    """Error of the assumed stiffness [%]. Of each axis, uniform up to this, drawn with the seed."""
    friction_spread: Annotated[float | None, Parameter(show_default=False)] = None
    """Spread of friction [%] [default: 2]. Of each axis, where no individual is given: uniform
    within +- this part of nominal."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.individual is None and self.friction_spread is None:
            object.__setattr__(self, "friction_spread", FRICTION_SPREAD)
        if self.individual is not None and self.friction_spread is not None:
            raise ValueError("friction-spread does not apply to an individual: its friction is own")
        check_limits(self, OF_CONTOUR)

    @cached_property
    def cell(self) -> Cell:
        """Cell of the robot. Raises ValueError for an unknown name or a wrong robot file."""
        return find_cell(self.robot)


def named_measure(cfg: Any) -> None:
    """Set the measure where none was given, and keep whether motors were asked for by name."""
    object.__setattr__(cfg, "motor_by_name", cfg.measure == "motor")
    object.__setattr__(cfg, "measure", cfg.measure or "motor")


@options
@dataclass(frozen=True, kw_only=True)
class LaserCfg(ContourCfg):
    """Robot, place, contour and learning."""

    law: Literal["auto", "heuristic", "simulated", "inverse", "norm-optimal"] = "auto"
    """Learning law. heuristic is Q(u + gamma q^delta e), thesis (9.2), simulated the same on the
    nominal robot between two runs (--measure motor); the others invert a model of the arm [auto:
    heuristic for --measure motor, inverse otherwise]."""
    measure: Literal["motor", "estimate", "tracker", "scan"] = NOT_NAMED
    """Learn from [default: motor]. Motor angles, the tool by an IMU estimate or the tracker, or a
    scan of each part that is cut, by a virtual scanner."""
    gamma: Annotated[tuple[float, ...], SOME] = _BY_ROBOT
    """Learning gain [default: 0.9]. One for all motors or six [default with --robot irb1400
    --measure motor: 1]."""
    delta: Annotated[tuple[int, ...], SOME] = _BY_ROBOT
    """Time shift [samples of 4 ms] [default: 3]. One for all motors or six [default with --robot
    irb1400 --measure motor: 8]."""
    cutoff: Annotated[tuple[float, ...], SOME] = _BY_ROBOT
    """Cutoff of Q [Hz] [default: 10; of the tool 13 to 20]. One for all motors or six [default with
    --robot irb1400 --measure motor: 20; where the tool's path is learned from 13, four times a
    contour's turns a second if that is more, up to 15, and the arm's lowest identified mode if that
    is more, up to 20]."""
    iterations: int = 5
    """Updates; one run more is made."""
    repetitions: int = 0
    """Further runs with the last correction. For path repeatability: none, or two and more."""
    beam: float = 0.2
    """Diameter of the laser beam [mm]. For the edges of the cut."""
    twin: Path | None = None
    """Folder of `armside commission`. Learn in this twin first, and correct the first run by it."""
    identification: Path | None = None
    """Folder of `armside identify`. Of this robot, in place of identifying from the first run."""
    on_imu_fault: Literal["refuse", "go-on"] = "refuse"
    """Reaction to an unusable IMU. Do not learn, or go on with motor angles and model alone."""

    motor_by_name: ClassVar[bool] = False
    """`--measure motor` was given, and is not only the default."""

    def __post_init__(self) -> None:
        super().__post_init__()
        named_measure(self)
        if self.gears is not None and self.twin is not None:
            raise ValueError("give gears or twin, not both: a twin knows gear errors of its own")
        check_limits(self, OF_LEARNING)
        motor = self.measure == "motor"
        design = default_design(self.cell) if motor else THESIS
        cutoff = design.cutoff if motor else (self._pass_band(),)
        defaults = {"gamma": design.gamma, "delta": design.delta, "cutoff": cutoff}
        for name, value in defaults.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        if self.repetitions < 0 or self.repetitions == 1:
            raise ValueError(f"repetitions must be 0, or 2 and more, got {self.repetitions}")
        for name in ("gamma", "delta", "cutoff"):
            axes = self.cell.robot.n_joints
            if (n := len(getattr(self, name))) not in (1, axes):
                many = "six" if axes == SIX else f"{axes}"
                raise ValueError(f"{name} takes one value or {many}, got {n}")
            if not motor and n > 1:
                raise ValueError(f"{name} takes one value with --measure {self.measure}")
        inverse = not motor and self.law in ("auto", "inverse")
        if inverse and self.gamma[0] >= LARGEST_INVERSE_GAIN:
            most = f"below {LARGEST_INVERSE_GAIN:g} with --law inverse"
            raise ValueError(f"gamma must be {most}, got {self.gamma[0]:g}")
        if motor and self.law in ("inverse", "norm-optimal"):
            raise ValueError(f"law {self.law} needs --measure estimate, tracker or scan")
        if not motor and self.law == "simulated":
            raise ValueError("law simulated needs --measure motor")
        if self.law == "simulated" and self.twin is not None:
            raise ValueError("law simulated learns on the nominal robot: give no twin with it")
        Design(gamma=self.gamma, delta=self.delta, cutoff=self.cutoff)

    @property
    def up_to_mode(self) -> bool:
        """The cutoff is the default, which follows contour and arm."""
        return self.measure != "motor" and self.cutoff == (self._pass_band(),)

    def _pass_band(self) -> float:
        """[Hz], of Q where the tool's path is learned from."""
        from armside.sim.estimation.tool_law import pass_band

        circle = self.shape == "circle" and self.contour is None and self.radius > 0.0
        return pass_band(self.speed / (2.0 * np.pi * self.radius) if circle else 0.0)
