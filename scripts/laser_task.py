"""From the options of `armside laser` to its task and its robot, in SI units."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.sim.cell import CELLS, ToolPose, pose
from armside.sim.cut.contour import Circle, ClosedCurve, hexagon, slot, square
from armside.sim.cut.task import CircleTask, ContourTask, CutTask, LeadIn
from armside.sim.cut.timing import PathLimits
from armside.sim.robot.individual import with_payload
from armside.sim.robot.model import RobotModel, load_model

from .laser_options import RADIUS, LaserCfg

if TYPE_CHECKING:
    from armside.sim.estimation.nominal import NominalArm

MM = 1e-3
SIZES: Mapping[str, float] = {"square": 20.0, "slot": 30.0, "hexagon": 20.0}
"""[mm], where none is given."""
CORNER = 0.15
"""Corner radius over size: 40 mm/s around a corner of 3 mm is below what the planner allows."""
_OWN = {
    "circle": ("radius",),
    "square": ("size", "corner"),
    "slot": ("size", "width"),
    "hexagon": ("size", "corner"),
}
_NOT_GIVEN = {"radius": RADIUS, "size": None, "width": None, "corner": None}


def task(cfg: LaserCfg) -> CutTask:
    """The task of the options.

    Raises:
        ValueError: an unknown pose, or options that do not go together.
    """
    curve = contour(cfg)
    if 0.5 * cfg.beam * MM >= curve.smallest_radius:
        raise ValueError(
            f"a beam of {cfg.beam:g} mm is too wide for bends with a radius of "
            f"{curve.smallest_radius / MM:g} mm"
        )
    common: dict[str, Any] = {
        "pose": tool_pose(cfg),
        "speed": cfg.speed * MM,
        "across_tool": cfg.plane == "tool",
        "lead_in": LeadIn(cfg.lead_in),
        "limits": PathLimits(acceleration=cfg.path_acceleration),
    }
    if isinstance(curve, Circle):
        return CircleTask(radius=curve.radius, **common)
    return ContourTask(contour=curve, **common)


def contour(cfg: LaserCfg) -> ClosedCurve:
    """What to cut. Raises ValueError for sizes that the shape has not, or that do not fit."""
    mm = dimensions(cfg)
    if cfg.contour is not None:
        return _from_file(cfg.contour, mm.get("corner"))
    if cfg.shape == "circle":
        return Circle(mm["radius"] * MM)
    size = mm["size"]
    if cfg.shape == "slot":
        width = mm["width"]
        if not width < size:
            raise ValueError(f"a slot of {size:g} mm must be narrower than that, got {width:g} mm")
        return slot(size * MM, width * MM)
    corner = mm["corner"]
    if corner > size / 2.0:
        raise ValueError(
            f"corner must be at most half of the {cfg.shape}'s {size:g} mm, got {corner:g} mm"
        )
    return {"square": square, "hexagon": hexagon}[cfg.shape](size * MM, corner * MM)


def dimensions(cfg: LaserCfg) -> dict[str, float]:
    """Sizes that the shape has [mm] by option, defaults filled in; a contour's corner if given.

    Raises ValueError for sizes that the shape has not.
    """
    own = ("corner",) if cfg.contour else _OWN[cfg.shape]
    what = "contour from a file" if cfg.contour else cfg.shape
    for name, not_given in _NOT_GIVEN.items():
        if name not in own and getattr(cfg, name) != not_given:
            raise ValueError(f"a {what} has no {name}; it has {' and '.join(own)}")
    given = {name: getattr(cfg, name) for name in own if getattr(cfg, name) is not None}
    if cfg.contour is not None or cfg.shape == "circle":
        return given
    size = given.get("size", SIZES[cfg.shape])
    derived = {"width": size / 3.0} if cfg.shape == "slot" else {"corner": CORNER * size}
    return {"size": size} | derived | given


def _from_file(file: Path, corner: float | None) -> ClosedCurve:
    from armside.sim.cut.contour_file import read_contour

    try:
        return read_contour(file, None if corner is None else corner * MM)
    except ImportError as error:
        raise ValueError(str(error)) from error


def tool_pose(cfg: LaserCfg) -> ToolPose:
    """The named pose, with position or orientation replaced where they are given."""
    named = pose(cfg.pose, CELLS[cfg.robot].poses)
    position, quaternion = named.position, named.quaternion
    if cfg.position is not None:
        x, y, z = cfg.position
        position = (x * MM, y * MM, z * MM)
    if cfg.quaternion is not None:
        length = float(np.linalg.norm(cfg.quaternion))
        if not 0.99 < length < 1.01:
            raise ValueError(f"quaternion must have length 1, got {length:.4g}")
        w, x, y, z = cfg.quaternion
        quaternion = (w / length, x / length, y / length, z / length)
    return ToolPose(position, quaternion)


def robot(cfg: LaserCfg) -> RobotModel:
    """The robot as its controller knows it. Raises ValueError for a payload it cannot carry."""
    model = load_model(cfg.model or CELLS[cfg.robot].xml)
    return model if cfg.payload is None else with_payload(model, cfg.payload)


def believed_arm(cfg: LaserCfg, seed: int) -> "NominalArm":
    """The arm as its owner believes it to be; its payload is known."""
    from . import arm_side

    return arm_side.believed_arm(
        load_model(cfg.model or CELLS[cfg.robot].xml),
        cfg.stiffness_error * 1e-2,
        seed,
        payload=added_payload(cfg),
    )


def added_payload(cfg: LaserCfg) -> float:
    """Mass of the tool beside that of the robot's file [kg]."""
    if cfg.payload is None:
        return 0.0
    return cfg.payload - float(
        load_model(cfg.model or CELLS[cfg.robot].xml).mj.body("tool").mass[0]
    )
