"""Plan of a whole part: paths of the beam's centre, their order, speeds and times."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from ..motion.profile_grid import BoundsAt
from ..motion.speed_profile import Bends, Profile, profiles
from ..motion.timing import PathLimits, rest_to_rest
from .arcs import MM, Chain, place
from .beam_path import CORNER, Led, compensated, led, meets, smooth
from .curve import Kind
from .drawing import shapely
from .order import order
from .part import Part, PartContour

TOGETHER = 64
"""Paths whose speeds are planned at once: memory does not grow with the number of contours."""
JointsAlong = Callable[[Sequence[Chain]], Sequence[BoundsAt | None]]
"""Limits of joints along paths in the drawing; None where they limit nothing."""


@dataclass(frozen=True, kw_only=True)
class Cutting:
    """Options of a plan. SI units."""

    speed: float = 0.040
    """Programmed speed along the contours [m/s]."""
    beam: float = 0.2 * MM
    """Diameter of the laser beam [m]; its centre runs half of it beside closed contours."""
    corner: float = CORNER
    """Radius with which sharp corners are cut [m]."""
    pierce: float = 0.3
    """Time to pierce the sheet [s]. ESTIMATE"""
    rapid: float = 0.5
    """Speed of rapid moves [m/s]. ESTIMATE"""
    joints: int = 0
    """Micro-joints along the outline, where the beam is off."""
    joint_width: float = 0.3 * MM
    """[m]."""
    limits: PathLimits = field(default_factory=PathLimits)

    def __post_init__(self) -> None:
        for name in ("speed", "beam", "corner", "rapid", "joint_width"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name.replace('_', '-')} must be > 0, got {value:g}")
        if not (np.isfinite(self.pierce) and self.pierce >= 0.0):
            raise ValueError(f"pierce must be >= 0 s, got {self.pierce:g}")
        if self.joints < 0:
            raise ValueError(f"the number of micro-joints must be >= 0, got {self.joints}")


@dataclass(frozen=True, kw_only=True)
class PlannedCut:
    """One contour of a plan."""

    contour: PartContour
    path: Chain = field(repr=False)
    """Of the beam's centre: lead-in, one turn, lead-out."""
    lead: float
    """Length of each lead [m]; 0 where there is no room for one."""
    profile: Profile = field(repr=False)
    joints: tuple[tuple[float, float], ...]
    """Begin and end of each micro-joint along the path [m]."""
    rapid: float
    """Length of the rapid move before it [m]."""
    rapid_seconds: float

    @property
    def reached_speed(self) -> float:
        """Highest speed [m/s]."""
        return float(self.profile.speed.max())

    @property
    def lowest_allowed(self) -> float:
        """Speed that its tightest bend allows, leads apart [m/s]; at most the programmed one."""
        s = self.profile.s
        own = (s > self.lead) & (s < self.path.length - self.lead)
        return float(self.profile.allowed[own].min())

    @property
    def seconds(self) -> float:
        """Of the cut alone."""
        return self.profile.timing.duration


@dataclass(frozen=True)
class Plan:
    """Cuts of a part in their order."""

    part: Part = field(repr=False)
    cutting: Cutting
    cuts: tuple[PlannedCut, ...]

    @property
    def seconds(self) -> float:
        """Of the whole part: rapid moves, piercing, cuts."""
        moving = sum(cut.seconds + cut.rapid_seconds for cut in self.cuts)
        return moving + len(self.cuts) * self.cutting.pierce


def plan(part: Part, cutting: Cutting | None = None, joints: JointsAlong | None = None) -> Plan:
    """Plan of a part. The tool starts at the lower left corner of its box.

    joints: limits of a robot's joints along paths; none if None.

    Raises ValueError, with contour and place, where the beam is too wide or a speed rests.
    """
    cutting = cutting or Cutting()
    led_paths = _paths(part.contours, cutting)
    entry = np.array([found.path.points[0] for found in led_paths])
    leave = np.array([found.path.points[-1] for found in led_paths])
    depth = [contour.depth for contour in part.contours]
    sequence = order(entry, leave, depth, part.box[0])
    begins = np.vstack([part.box[0], leave[sequence[:-1]]])
    speeds = _profiles([found.path for found in led_paths], cutting, joints)
    cuts = []
    for i, begin in zip(sequence, begins, strict=True):
        (path, lead), contour = led_paths[i], part.contours[i]
        if len(speeds[i].rests):  # the tool would all but rest within a cut for no limit's sake
            at = float(speeds[i].rests[0])
            raise ValueError(
                f"{contour.name}: no speeds found that keep it moving at {place(path.point(at))}, "
                f"{at / MM:.1f} mm along the path; try another speed or a larger corner"
            )
        rapid = float(np.linalg.norm(entry[i] - begin))
        moves = rest_to_rest(rapid, cutting.rapid, cutting.limits) if rapid >= 1e-9 else None
        cuts.append(
            PlannedCut(
                contour=contour,
                path=path,
                lead=lead,
                profile=speeds[i],
                joints=tuple(_joints(contour, path.length, lead, cutting)),
                rapid=rapid,
                rapid_seconds=moves.duration if moves else 0.0,
            )
        )
    return Plan(part, cutting, tuple(cuts))


def _paths(contours: Sequence[PartContour], cutting: Cutting) -> list[Led]:
    """Paths of the beam's centre. Raise ValueError where a beam cuts into another contour."""
    half = 0.5 * cutting.beam
    rounded = []
    for contour in contours:
        with _named(contour):
            rounded.append(smooth(contour.chain, cutting.corner))
    tree, found = shapely.STRtree([shapely.LineString(r.polygon()) for r in rounded]), []
    for i, contour in enumerate(contours):
        if contour.kind is Kind.OPEN:
            found.append(Led(rounded[i], 0.0))
            continue
        outwards = contour.kind is Kind.OUTLINE
        with _named(contour):
            path = compensated(rounded[i], half, outwards)
            found.append(led(path, not outwards, half, tree, i))
    lines = [shapely.LineString(each.path.polygon()) for each in found]
    for i, j in meets(lines, half, tree).T:
        if i != j:
            between = shapely.shortest_line(lines[i], tree.geometries[j])
            raise ValueError(
                f"{contours[i].name}: the beam of {cutting.beam / MM:g} mm cuts into "
                f"{contours[j].name} at {place(shapely.get_coordinates(between)[-1])}, "
                f"{shapely.length(between) / MM:.3g} mm from its centre; take a narrower beam, or "
                "draw them further apart"
            )
    return found


@contextmanager
def _named(contour: PartContour) -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{contour.name}: {error}") from error


def _profiles(
    paths: Sequence[Chain], cutting: Cutting, joints: JointsAlong | None
) -> list[Profile]:
    """Speed profiles, one for all paths of the same elements that no joint limits."""
    known, keys = dict[int | bytes, Profile](), list[int | bytes]()
    for begin in range(0, len(paths), TOGETHER):
        some = paths[begin : begin + TOGETHER]
        free, limited = dict[int | bytes, Bends](), dict[int | bytes, Bends]()
        bounds = [None] * len(some) if joints is None else joints(some)
        for path, bound in zip(some, bounds, strict=True):
            elements = np.column_stack([path.lengths, path.curvature])
            keys.append(np.round(elements, 9).tobytes() if bound is None else len(keys))
            if keys[-1] not in known:
                (free if bound is None else limited)[keys[-1]] = Bends(*elements.T, bounds=bound)
        new = free | limited
        made = profiles(list(new.values()), cutting.speed, cutting.limits)
        known |= zip(new, made, strict=True)
    return [known[key] for key in keys]


def _joints(
    contour: PartContour, length: float, lead: float, cutting: Cutting
) -> Iterator[tuple[float, float]]:
    """Micro-joints, evenly along the outline and half a distance from its start."""
    if contour.kind is not Kind.OUTLINE or not cutting.joints:
        return
    turn = length - 2.0 * lead
    if cutting.joints * cutting.joint_width > 0.5 * turn:
        raise ValueError(f"{contour.name} is too short for {cutting.joints} micro-joints")
    for middle in turn * (np.arange(cutting.joints) + 0.5) / cutting.joints:
        at = float(lead + middle)
        yield at - 0.5 * cutting.joint_width, at + 0.5 * cutting.joint_width


def rapid_moves(found: Plan) -> Array:
    """(M, 2, 2) [m], begin and end of the rapid move before each cut."""
    ends = np.array([cut.path.points[[0, -1]] for cut in found.cuts])
    begins = np.vstack([found.part.box[:1], ends[:-1, 1]])
    return np.stack([begins, ends[:, 0]], axis=1)
