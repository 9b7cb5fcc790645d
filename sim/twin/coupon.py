"""The coupon: a sheet of contours that a twin is commissioned from, by a scan of it.

Four kinds of contours, each cut counter-clockwise in one column and clockwise in the other, so that
a kerf which differs between the two is told from the tool; slow and fast. Places and sizes follow
the sheet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..cell import TOOL_QUATERNION, ToolPose
from ..laser.experiment import Experiment, Pass
from ..laser.specification import Cut
from ..motion.contour import ArcsAndLines, Circle, clockwise, hexagon, slot, square
from ..part.arcs import Chain, line
from ..part.curve import ChainCurve
from ..scan.reading import SheetScan
from ..scan.virtual_reading import BeamPath
from .recordings import MeasuredCut, ScannedCut

SHEET = (0.16, 0.24)
"""[m], width and height: two columns and four rows fit on an A4 scanner."""
PLACE = (1.8, 0.1, 1.5992)
"""[m], middle of the sheet in base axes: p2 of thesis (9.3)."""
_FILL = 0.6
"""Size of a contour over the least side of its cell."""
_SHAPES = ("circle", "square", "hexagon", "slot")
_SPEEDS = ((0.060, 0.100), (0.060, 0.035), (0.035, 0.060), (0.080, 0.050))
"""[m/s] by row, counter-clockwise and clockwise: each shape slow and fast."""


@dataclass(frozen=True, kw_only=True)
class CouponContour:
    """One contour of a coupon."""

    curve: Circle | ArcsAndLines
    """As drawn."""
    middle: tuple[float, float]
    """[m], from the middle of the sheet."""
    clockwise: bool
    speed: float
    """[m/s]."""


def coupon(sheet: tuple[float, float] = SHEET) -> dict[str, CouponContour]:
    """Contours of a sheet of that width and height [m], by name, in the order in which they are
    cut. Raises ValueError for a sheet without room for them."""
    wide, high = 0.5 * sheet[0], 0.25 * sheet[1]
    size = _FILL * min(wide, high)
    if not size >= _LEAST:
        raise ValueError(
            f"a sheet of {1e3 * sheet[0]:g} by {1e3 * sheet[1]:g} mm leaves {1e3 * size:.3g} mm "
            f"for a contour; it must be at least {1e3 * _LEAST:g}"
        )
    found = dict[str, CouponContour]()
    for column in range(2):
        for row, shape in enumerate(_SHAPES):
            found[f"{shape}-{'cw' if column else 'ccw'}"] = CouponContour(
                curve=_curve(shape, size, _FILL * wide),
                middle=((column - 0.5) * wide, (1.5 - row) * high),
                clockwise=bool(column),
                speed=_SPEEDS[row][column],
            )
    return found


_MARK, _MARK_RADIUS = -0.2, 0.0015
"""Place of the mark beside the middle, over half the width of the sheet; and its radius [m]."""
_LEAST = 0.008
"""[m], of a contour: below it corners of 15 % are too tight. ESTIMATE."""


def _curve(shape: str, size: float, longest: float) -> Circle | ArcsAndLines:
    match shape:
        case "circle":
            return Circle(0.5 * size)
        case "square":
            return square(size, 0.15 * size)
        case "hexagon":
            return hexagon(size, 0.15 * size)
        case _:
            return slot(max(longest, 1.5 * size), 0.5 * size)


def drawing(sheet: tuple[float, float] = SHEET) -> dict[str, ChainCurve]:
    """Contours of a coupon as drawn about the middle of its sheet, each from where its cut starts,
    and the two that no twin is identified from: a mark beside the middle, by which a scan knows the
    sheet's top and its face, and an open kerf that shows the beam's width. Raises as `coupon`."""
    x, y = _MARK * 0.5 * sheet[0], 0.25 * sheet[1]
    ends = (0.5 * x, y), (-x, y)
    mark = _chain(Circle(_MARK_RADIUS), (x, y))
    contours = {n: _chain(one.curve, one.middle) for n, one in coupon(sheet).items()}
    chains = {**contours, "mark": mark, "kerf": line(*ends)}
    return {name: ChainCurve(chain) for name, chain in chains.items()}


def _chain(curve: Circle | ArcsAndLines, middle: tuple[float, float]) -> Chain:
    lengths, bends = (
        (2 * [0.5 * curve.length], 2 * [1.0 / curve.radius])
        if isinstance(curve, Circle)
        else zip(*curve.elements, strict=True)
    )
    points = curve.point(np.cumsum([0.0, *lengths])) + middle
    points[-1] = points[0]
    return Chain(points, np.tan(0.25 * np.multiply(lengths, bends)))


def coupon_cut(one: CouponContour, place: tuple[float, float, float] = PLACE) -> Cut:
    """Cut of a contour of the coupon, whose middle is at a place [m] in base axes."""
    x, y, z = (float(v) for v in np.add(place, (*one.middle, 0.0)))
    curve = clockwise(one.curve) if one.clockwise else one.curve
    return Cut(pose=ToolPose((x, y, z), TOOL_QUATERNION), contour=curve, speed=one.speed)


def beam_path(one: CouponContour, experiment: Experiment, run: Pass) -> BeamPath:
    """Where the beam was in a virtual run."""
    time, position = run.true
    motion = experiment.motion
    on = motion.is_on_contour(time)
    path = motion.plane.from_base(position[on])[:, :2] + one.middle
    return BeamPath(curve=one.curve, middle=one.middle, path=path, clockwise=one.clockwise)


def scanned(
    cut: MeasuredCut,
    name: str,
    contours: Mapping[str, CouponContour],
    scan: SheetScan,
    contour_time: tuple[float, float],
    place: tuple[float, float, float] = PLACE,
) -> MeasuredCut:
    """A recorded cut of the coupon with what the scan says of its contour."""
    one, names = contours[name], list(contours)
    seen = ScannedCut(
        contour=scan.contours[name],
        curve=one.curve,
        middle=np.array(one.middle),
        plane=coupon_cut(one, place).plane,
        contour_time=contour_time,
        clockwise=one.clockwise,
        number=names.index(name),
        count=len(names),
        scale=scan.scale,
        beam_measured=scan.beam_measured,
    )
    return replace(cut, scan=seen)
