"""Option of a gear error that `armside gears` found, and its part in a cut."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter

from armside.kinematics import Robot
from armside.kinematics.robot_file import read_gear_file

from ..shell.options import check_read, options
from .individual import IndividualCfg, robot_state


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
