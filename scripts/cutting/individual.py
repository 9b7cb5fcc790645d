"""Options that say which robot individual cuts, and in which state."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Group, Parameter

from armside.kinematics import Robot
from armside.kinematics.robot_file import read_gear_file
from armside.sim.robot.effects import TEMPERATURES, Effect
from armside.sim.robot.individual_file import read_individual
from armside.sim.robot.spread import Drawn

from ..shell.options import LARGEST_SEED, check_read, options

EffectName = Literal["lost-motion", "gear-error", "ripple", "load-friction"]
_GROUP = Group("Robot individual", sort_key=5)
_OF_ROBOT = Parameter(group=_GROUP)
_SEVERAL = Parameter(group=_GROUP, consume_multiple=True)
MOST_DRIFT = 1000.0
"""[%]"""


@options
@dataclass(frozen=True, kw_only=True)
class IndividualCfg:
    """Robot individual and its state."""

    individual: Annotated[int | Path | None, Parameter(group=_GROUP, validator=check_read)] = None
    """Robot individual, apart from the seed of noise and set-up: its number in the production line,
    or a TOML file of its parameters [default: the design with a friction of its own]."""
    friction_drift: Annotated[float, _OF_ROBOT] = 0.0
    """Change of Coulomb and static friction [%]."""
    temperature: Annotated[float | None, _OF_ROBOT] = None
    """Temperature of the gears, 26 to 80 [deg C] [default: as in the model]."""
    without: Annotated[tuple[EffectName, ...], _SEVERAL] = ()
    """Effects of gears and drives to leave out, for ablations."""

    def __post_init__(self) -> None:
        if isinstance(self.individual, int) and self.individual < 0:
            raise ValueError(f"individual must be >= 0, or a TOML file, got {self.individual}")
        if isinstance(self.individual, int) and self.individual > LARGEST_SEED:
            raise ValueError(f"individual must be below 2^63, got {self.individual:.4e}")
        if not -100.0 < self.friction_drift <= MOST_DRIFT:
            allowed = f"in (-100, {MOST_DRIFT:g}] %"
            raise ValueError(f"friction-drift must be {allowed}, got {self.friction_drift:g}")
        coldest, warmest = TEMPERATURES
        if self.temperature is not None and not coldest <= self.temperature <= warmest:
            allowed = f"from {coldest:g} to {warmest:g} deg C"
            raise ValueError(f"temperature must be {allowed}, got {self.temperature:g}")
        if self.temperature is not None and "load-friction" in self.without:
            raise ValueError("temperature acts through load-friction: do not leave it out")


def robot_state(cfg: IndividualCfg) -> dict[str, Any]:
    """Fields of `armside.sim.laser.Cut` of the options, in SI.

    Raises ValueError or OSError for a file of an individual that cannot be used.
    """
    chosen = cfg.individual
    return {
        "individual": read_individual(chosen) if isinstance(chosen, Path) else _drawn(chosen),
        "friction_drift": cfg.friction_drift * 1e-2,
        "temperature": cfg.temperature,
        "without": tuple(Effect(name) for name in cfg.without),
    }


def _drawn(number: int | None) -> Drawn | None:
    return None if number is None else Drawn(number)


@options
@dataclass(frozen=True, kw_only=True)
class KnownGearsCfg(IndividualCfg):
    """Robot individual, and what is known of its gears."""

    gears: Annotated[
        Path | None,
        Parameter(group=Group("Robot individual", sort_key=5), validator=check_read),
    ] = None
    """File gears.toml of `armside gears` for this robot individual: its motors then follow what
    makes the tool right, and the estimate knows its gear error."""


def known_state(cfg: KnownGearsCfg, robot: Robot) -> dict[str, Any]:
    """Fields of `armside.sim.laser.Cut` of the options, in SI.

    Raises ValueError or OSError for a file that cannot be used, or one of another robot.
    """
    terms = () if cfg.gears is None else read_gear_file(cfg.gears, robot)
    return robot_state(cfg) | {"gear_error": terms}
