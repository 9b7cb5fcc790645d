"""Options of `armside cut`, in the units that a person types."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from cyclopts import Group, Parameter

from armside.sim.instruments.imu import ImuCfg
from armside.sim.motion.timing import PathLimits
from armside.sim.part.arcs import MM
from armside.sim.part.drawing import Reading, Unit
from armside.sim.records.files import check_file
from armside.sim.robot_file.find import find_cell

from ..shell.effort import refuse_absurd
from ..shell.errors import InputError
from ..shell.options import PERCENT, FileToRead, Limits, check_limits, options
from .earlier import Earlier
from .options import (
    BEAM,
    FRICTION_SPREAD,
    NOT_NAMED,
    OF_ROBOT,
    SIX,
    KnownGearsCfg,
    known_state,
    named_measure,
)
from .specification import effort

if TYPE_CHECKING:  # its package needs the extra of drawings
    from armside.sim.laser.part_cut import PartCut

_PLAN = Group("Drawing and plan", sort_key=1)
_OF_PLAN = Parameter(group=_PLAN)
_SEVERAL = Parameter(group=_PLAN, consume_multiple=True)
OF_PLAN = OF_ROBOT | {
    "join": Limits(1e-3, 1e3, "mm"),
    "corner": Limits(1e-3, 1e3, "mm"),
    "beam": BEAM,
    "joint_width": Limits(1e-3, 1e3, "mm"),
    "rapid": OF_ROBOT["speed"],
    "pierce": Limits(0.0, 600.0, "s"),
    "micro_joints": Limits(0, 1000),
    "converged": PERCENT,
    "iterations": Limits(0),
}


SPACING = Limits(0.1, 100.0, "mm")


@options
@dataclass(frozen=True, kw_only=True)
class CutCfg(KnownGearsCfg):
    """Drawing, plan, robot and learning."""

    layers: Annotated[tuple[str, ...], _SEVERAL] = ()
    """Layers of the drawing to cut [default: all that are visible]."""
    units: Annotated[Literal["mm", "inch"] | None, _OF_PLAN] = None
    """Unit of the drawing. Where it does not say its own or says a wrong one."""
    join: Annotated[float, _OF_PLAN] = 0.05
    """Largest distance between ends that are joined [mm]."""
    corner: Annotated[float, _OF_PLAN] = 0.5
    """Radius of sharp corners [mm]."""
    beam: Annotated[float, _OF_PLAN] = 0.2
    """Diameter of the laser beam [mm]. Its centre runs half of it beside each contour."""
    speed: Annotated[float, _OF_PLAN] = 40.0
    """Programmed speed along the contours [mm/s]."""
    rapid: Annotated[float, _OF_PLAN] = 200.0
    """Speed of rapid moves [mm/s]."""
    pierce: Annotated[float, _OF_PLAN] = 0.3
    """Rest before each cut [s]. In it the beam pierces the sheet."""
    micro_joints: Annotated[int, _OF_PLAN] = 0
    """Places along the outline at which the beam is off."""
    joint_width: Annotated[float, _OF_PLAN] = 0.3
    """Width of such a place [mm]."""
    path_acceleration: Annotated[float, _OF_PLAN] = 1.3
    """Limit of acceleration [m/s^2]. Of the controller, along and across the path."""
    plan_only: Annotated[bool, _OF_PLAN] = False
    """Plan and draw the plan, and move nothing."""
    as_program: Annotated[Literal["rapid", "krl", "urscript"] | None, _OF_PLAN] = None
    """Write a program too. Of linear moves, with the last correction: see docs/programs.md."""
    spacing: Annotated[float | Literal["auto"], _OF_PLAN] = "auto"
    """Largest distance of its targets [mm]. auto: speed over twice the pass band of learning
    from the tool, and half of the smallest radius."""
    robot: str = "large"
    """large, irb1400, or a robot file (.toml). Of six axes."""
    model: FileToRead = None
    """MJCF file to use in place of that robot's own."""
    payload: float | None = None
    """Mass of the tool [kg] [default: as in the model]. The controller knows it."""
    pose: str = "p1"
    """Named pose. The middle of the part lies there, with its orientation of the tool."""
    plane: Literal["base-xy", "tool"] = "base-xy"
    """Plane. The base x-y plane, or perpendicular to the tool axis."""
    measure: Literal["motor", "estimate", "tracker", "scan"] = NOT_NAMED
    """Learn from [default: motor]. Motor angles, the tool by an IMU estimate or the tracker, or a
    scan of each part that is cut, by a virtual scanner."""
    iterations: int = 5
    """Updates, of each contour at most; one run more is made."""
    twin: Path | None = None
    """Folder of `armside commission`. Learn in this twin first, and correct the first run by it."""
    converged: float = 0.0
    """Least progress of two updates [%]. A contour whose learned error falls by less in two updates
    running has converged: it keeps its best correction, and the run ends when all have [0: all
    updates are made]."""

    motor_by_name: ClassVar[bool] = False
    """As of `LaserCfg`."""

    def __post_init__(self) -> None:
        super().__post_init__()
        named_measure(self)
        if (n := find_cell(self.robot).robot.n_joints) != SIX:
            needs = f"cut plans with six axes, {self.robot} has {n}"
            raise ValueError(f"{needs}: cut its contours one by one with armside laser --contour")
        check_limits(self, OF_PLAN)
        if self.spacing != "auto":
            SPACING.check("spacing", self.spacing)
            if self.as_program is None:
                raise ValueError("spacing is of --as-program: give that too")


def drawing(file: Path | None, before: Earlier | None) -> Path:
    """The drawing that was given, or that of the earlier run. Raises InputError for none."""
    if file is not None:
        return file
    if before is None:
        raise InputError("a drawing is needed (.dxf, .svg, .toml), or --from RUN")
    return check_file(Path(before.run.summary["part"]))


def part_cut(file: Path, cfg: CutCfg) -> "PartCut":
    """A drawing in its cell, in SI. Raises ValueError for one that cannot be cut, with the place,
    or an unknown pose, and InputError for one that would take too long."""
    unit = None if cfg.units is None else Unit(cfg.units)
    try:
        from armside.sim.laser.part_cut import PartCut
        from armside.sim.part.part import read_part
        from armside.sim.part.plan import Cutting

        part = read_part(file, Reading(layers=cfg.layers, unit=unit, join=cfg.join * MM))
    except ModuleNotFoundError as error:
        raise ValueError(
            f"drawings need packages: pip install 'armside[parts]' ({error})"
        ) from error
    length, runs = sum(contour.chain.length for contour in part.contours), cfg.iterations + 1
    what = f"{runs} runs along {length / MM:.4g} mm at {cfg.speed:g} mm/s"
    estimated = cfg.measure == "estimate"
    refuse_absurd(what, effort(length, cfg.speed * MM, runs, estimated=estimated))
    limits = PathLimits(acceleration=cfg.path_acceleration)
    found = PartCut(
        part=part,
        cutting=Cutting(
            speed=cfg.speed * MM,
            beam=cfg.beam * MM,
            corner=cfg.corner * MM,
            pierce=cfg.pierce,
            rapid=cfg.rapid * MM,
            joints=cfg.micro_joints,
            joint_width=cfg.joint_width * MM,
            limits=limits,
        ),
        robot=cfg.robot,
        model=cfg.model,
        pose=cfg.pose,
        across_tool=cfg.plane == "tool",
        limits=limits,
        payload=cfg.payload,
        friction_spread=FRICTION_SPREAD * 1e-2,
        imu=None if cfg.measure in ("motor", "scan") else ImuCfg(),
        **known_state(cfg, find_cell(cfg.robot).robot),
    )
    found.tool_pose  # noqa: B018 - raises for an unknown pose
    return found
