"""Specification of a cut and of its measure, in SI, from the options of a command."""

from collections.abc import Mapping

import numpy as np

from armside.sim.cell import ToolPose, pose
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.design import Design
from armside.sim.laser.measures import Measure, MotorAngles
from armside.sim.laser.specification import Cut, LeadIn
from armside.sim.motion.contour import CORNER, Circle, ClosedCurve, hexagon, slot, square
from armside.sim.motion.timing import PathLimits

from ..shell.effort import Effort, refuse_absurd
from .options import RADIUS, ContourCfg, LaserCfg, known_state

LEADS = 1.5
"""Length of the programmed path over that of the contour, rounded up."""
REST = 2.0
"""[s], of each run beside the cut: rest before and after, acceleration."""
PLANNING = Effort(0.2, 20e6)
"""For each second of motion, before the first run: reference, statics and physics of one run."""
RUN = Effort(0.1, 2e6)
"""For each second of a run: physics, and the signals that are kept."""
ESTIMATED = Effort(3.0, 4e6)
"""For each second of a run, where the tool is estimated besides."""


def effort(length: float, speed: float, runs: int, *, estimated: bool = False) -> Effort:
    """Estimate for runs along a contour. length: [m]. speed: [m/s]."""
    seconds = LEADS * length / speed + REST
    each = RUN + ESTIMATED if estimated else RUN
    return (PLANNING + each * runs) * seconds


MM = 1e-3
SIZES: Mapping[str, float] = {"square": 20.0, "slot": 30.0, "hexagon": 20.0}
"""[mm], where none is given."""
_POLYGON = ("size", "corner")
_OWN = {"circle": ("radius",), "square": _POLYGON, "slot": ("size", "width"), "hexagon": _POLYGON}
_NOT_GIVEN = {"radius": RADIUS, "size": None, "width": None, "corner": None}


def cut(cfg: LaserCfg) -> Cut:
    """The cut of the options. Raises ValueError for an unknown pose or options that misfit."""
    curve = contour(cfg)
    if 0.5 * cfg.beam * MM >= curve.smallest_radius:
        bends = f"bends with a radius of {curve.smallest_radius / MM:g} mm"
        raise ValueError(f"a beam of {cfg.beam:g} mm is too wide for {bends}")
    return _cut(cfg, curve, cfg.iterations + 1 + cfg.repetitions, cfg.measure)


def cut_with_imu(cfg: ContourCfg) -> Cut:
    """A single cut of the options, with an IMU at the tool. Raises ValueError as `cut`."""
    return _cut(cfg, contour(cfg), 1, "estimate")


def _cut(cfg: ContourCfg, curve: ClosedCurve, runs: int, measure: str) -> Cut:
    """The cut, unless so many runs would take too long or too much memory."""
    what = f"{runs} runs along {curve.length / MM:.4g} mm at {cfg.speed:g} mm/s"
    estimated = measure == "estimate"
    refuse_absurd(what, effort(curve.length, cfg.speed * MM, runs, estimated=estimated))
    return Cut(
        robot=cfg.robot,
        model=cfg.model,
        pose=tool_pose(cfg),
        contour=curve,
        speed=cfg.speed * MM,
        across_tool=cfg.plane == "tool",
        lead_in=LeadIn(cfg.lead_in),
        limits=PathLimits(acceleration=cfg.path_acceleration),
        payload=cfg.payload,
        friction_spread=(cfg.friction_spread or 0.0) * 1e-2,
        **known_state(cfg, cfg.cell.robot),
        imu=None if measure in ("motor", "scan") else ImuCfg(),
    )


def measure(cfg: LaserCfg) -> Measure:
    """The measured output of the options, with its law.

    Raises InputError where the folder of an identification holds none, or one of another robot.
    """
    parameters = None
    if cfg.identification is not None:
        from armside.sim.estimation.elasticity import read_parameters

        parameters = read_parameters(cfg.identification, cfg.robot, cfg.cell.robot.n_joints)
    if cfg.measure == "motor":
        design = Design(gamma=cfg.gamma, delta=cfg.delta, cutoff=cfg.cutoff)
        return MotorAngles(design, simulated=cfg.law == "simulated")
    from armside.sim.estimation.commissioning import Commissioning, OnFault
    from armside.sim.estimation.tool_law import ToolLaw, ToolLawKind
    from armside.sim.laser.tool_measure import Source, ToolPath

    kind = ToolLawKind("inverse" if cfg.law == "auto" else cfg.law)
    (gamma, *_), (delta, *_), (cutoff, *_) = cfg.gamma, cfg.delta, cfg.cutoff
    law = ToolLaw(kind=kind, gamma=gamma, delta=delta, cutoff=None if cfg.up_to_mode else cutoff)
    if cfg.measure == "scan":
        from armside.sim.laser.scan_measure import ScannedPart

        return ScannedPart(
            law=law, parameters=parameters, stiffness_error=cfg.stiffness_error * 1e-2
        )
    return ToolPath(
        source=Source(cfg.measure),
        law=law,
        commissioning=Commissioning(on_fault=OnFault(cfg.on_imu_fault)),
        stiffness_error=cfg.stiffness_error * 1e-2,
        parameters=parameters,
    )


def contour(cfg: ContourCfg) -> ClosedCurve:
    """Contour of the options. Raises ValueError for sizes that the shape lacks, or that misfit."""
    mm = dimensions(cfg)
    if cfg.contour is not None:
        from armside.sim.part.contour_file import read_contour

        try:
            return read_contour(cfg.contour, mm["corner"] * MM if "corner" in mm else None)
        except ImportError as error:
            raise ValueError(str(error)) from error
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
        half = f"half of the {cfg.shape}'s {size:g} mm"
        raise ValueError(f"corner must be at most {half}, got {corner:g} mm")
    return {"square": square, "hexagon": hexagon}[cfg.shape](size * MM, corner * MM)


def dimensions(cfg: ContourCfg) -> dict[str, float]:
    """Sizes that the shape has [mm] by option, defaults filled in; a contour's corner if given.
    Raises ValueError for sizes that the shape has not."""
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


def tool_pose(cfg: ContourCfg) -> ToolPose:
    """The named pose, with position or orientation replaced where they are given."""
    named = pose(cfg.pose, cfg.cell.poses)
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
