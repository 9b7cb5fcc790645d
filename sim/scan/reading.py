"""What a scan of a cut sheet says: deviation of the beam across each contour, by arc length."""

import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..motion.contour import ClosedCurve, outward_normal
from ..notes import Cause, Note
from .calibration import Calibration
from .image import BLURRED, WHITE, WINDOW, Edge, ScanImage, edge_near, kerf_near, outlines
from .placement import (
    FARTHEST,
    FOUND,
    WIDER,
    DrawnContour,
    Pose,
    Seen,
    followed,
    located,
    own_outline,
    rigid_step,
    shift,
)

BEAM = 0.2e-3
"""Diameter of the beam where nothing says it [m]; as `part.plan.Cutting`."""
BIN = 0.2e-3
"""Length of a bin along a contour [m]."""
SPACING = 0.1e-3
"""Distance of the points of an expected edge [m]."""
STEPS = 4
"""Gauss-Newton steps of the placement; it begins within some 0.1 mm."""
CLOSED = 1e-6
"""Distance of the ends of a closed curve [m]."""
ENDS = 0.5e-3
"""Length at both ends of an open kerf that is not used [m]: they are round."""
TOGETHER = 40e-6
"""Distance from a bin's median of the points that its mean is of [m]."""
NEIGHBOURS = 8
"""Bins on each side by which one is judged."""
DEGREE = 4
"""Of the polynomial through them: waves of 4 mm follow it to some percent."""
OUTLYING = 35e-6
"""Least distance from its neighbours' course at which a bin is a tear, a burr or dust [m]."""
COVERED = 0.6
"""Least part of a contour that has to be seen."""
ROUGH = 30e-6
"""Largest roughness of a bin [m]: seven times a laser's, and of burrs or dirt all around."""
KERF_DIFFERS = 10e-6
"""Difference of the measured beam from the given one that is noted [m]."""
EDGE = 3e-6
"""Waves of a cut's edge over millimetres that are not the beam's, RMS [m]. ESTIMATE"""
UNCALIBRATED = 10e-6
"""Wobble of a scanner that nobody calibrated, RMS [m]. ESTIMATE, of 10 to 30 um peak."""
SCALE = 1e-3
"""Standard deviation of the scale of such a scanner. ESTIMATE; one was found 6e-3 off."""
WIDE = 30e-3
"""Half the size of a sheet from which on its scale is told from the beam's width [m]."""
SCALED = 2e-3
"""Scale of a sheet in x or y from which it is said. ESTIMATE, twice `SCALE`: a robot that is not
corrected cuts corners, and was seen 3e-3 too small."""


@dataclass(frozen=True, kw_only=True)
class ScannedContour:
    """Where the beam was across one contour, of which a scan sees one edge or both.

    Nothing is known along the path, in height, or where the sheet lay in the robot's base.
    """

    arc_length: Array
    """(M,) [m], of the drawn contour, increasing; places that are torn or burred are not in it."""
    deviation: Array
    """(M,) [m], middle of the beam less the drawn contour, along `motion.contour.outward_normal`,
    after the placement of the sheet and half the beam are taken off; of a contour that is drawn as
    an edge, the edge less the drawn one."""
    noise: float
    """Standard deviation [m] of a value of `deviation` in a bin of 0.2 mm."""


@dataclass(frozen=True, kw_only=True)
class SheetScan:
    """Contours of one sheet as scanned, by their names on the drawing."""

    contours: Mapping[str, ScannedContour]
    placement: tuple[float, float, float]
    """x, y [m] and angle [rad] of the drawing in the image, by a best fit of all contours."""
    beam: float
    """Diameter [m], half of which was taken off."""
    beam_measured: bool
    """Whether a kerf with both edges visible gave the beam, or it was assumed."""
    scale: float
    """Standard deviation of the scanner's scale, a ratio: 1e-4 calibrated, 1e-3 not."""
    notes: tuple[Note, ...] = ()


def read_scan(
    image: ScanImage,
    drawing: Mapping[str, ClosedCurve],
    *,
    pieces: Collection[str] = (),
    calibration: Calibration | None = None,
    beam: float | None = None,
    edges: bool = False,
    wider: float = WIDER,
) -> SheetScan:
    """Deviation of the beam across each contour of a drawing, from an image of the cut sheet.

    drawing: curves in the coordinates of the drawing [m], by name. A closed one is seen as a hole
        in the sheet, unless it is one of the `pieces`, of which the material lies inside; an open
        one as a kerf with both edges.
    beam: diameter [m]; None takes it from the open kerfs, or `BEAM` if there is none.
    edges: a closed contour is drawn as the edge that is wanted, as of a part whose path runs half
        a beam beside it, and deviations are the edge's; else as the middle of the beam.
    wider: offset of a whole edge by which an outline may still be a contour [m].

    Raises ValueError, in one line, for an image that is not such a sheet, as a whole and sharp.
    """
    try:
        drawn = _drawn(drawing, pieces)
        return _read(image, drawn, calibration, beam, edges, wider)
    except ValueError as error:
        raise ValueError(f"{image.name}: {str(error).removeprefix(f'{image.name}: ')}") from error


def _drawn(drawing: Mapping[str, ClosedCurve], pieces: Collection[str]) -> list[DrawnContour]:
    drawn = list[DrawnContour]()
    for name, curve in drawing.items():
        first, last = curve.point(np.array([0.0, curve.length]))
        seen = Seen.PIECE if name in pieces else Seen.HOLE
        if np.linalg.norm(last - first) > CLOSED:
            seen = Seen.KERF
        drawn.append(DrawnContour(name, curve, seen))
    return drawn


def _read(
    image: ScanImage,
    drawn: Sequence[DrawnContour],
    calibration: Calibration | None,
    beam: float | None,
    edges: bool,
    wider: float,
) -> SheetScan:
    if calibration is not None:
        calibration.check(image)
    closed = [contour for contour in drawn if contour.seen is not Seen.KERF]
    shortest = 0.7 * min((contour.curve.length for contour in closed), default=0.0)
    found = outlines(image, shortest)
    pose = located(drawn, found, wider)
    own = {contour.name: own_outline(pose, contour, found, wider) for contour in closed}
    shifts = [shift(pose, contour, own[contour.name]) for contour in closed]
    notes = list[str]()
    if pose.mirrored:
        notes.append("the sheet is mirrored: its other face was scanned, where the beam leaves it")
    sides = list[_Side]()
    for contour in drawn:
        middle = contour.coarse[0].mean(axis=0)
        apart = [np.linalg.norm(c.coarse[0].mean(axis=0) - middle) for c in closed]
        moved = shifts[int(np.argmin(apart))]
        is_kerf = contour.seen is Seen.KERF
        expected, normal = contour.edge(SPACING, 0.5 * BEAM * contour.seen.value)
        at, out = pose.to_image(expected) + moved, normal @ pose.matrix.T
        half = 0.0
        if not is_kerf:
            at = followed(at, out, own[contour.name])
        if is_kerf:
            beside, width = kerf_near(image, at, out)
            at, half = at + beside[:, np.newaxis] * out, 0.5 * width
        for sign in (1, -1) if is_kerf else (contour.seen.value,):
            away, narrow = (sign * out, half) if is_kerf else (out, 0.0)
            edge = edge_near(image, at + narrow * away, away, narrow=narrow)
            sides.append(_Side(contour, sign, edge))
    _check(sides)
    points = [side.edge.points for side in sides]
    if calibration is not None:
        points = [calibration.corrected(each) for each in points]
    widths, bins = list[Array](), list[_Bins]()
    for _ in range(STEPS):
        bins = [
            _binned(side, pose.to_drawing(each)) for side, each in zip(sides, points, strict=True)
        ]
        widths = _kerfs(sides, bins)
        half = 0.5 * _beam(widths, beam)
        pose = pose.moved(_step(pose, sides, bins, half, edges))
    measured = beam is None and len(widths) > 0
    diameter = _beam(widths, beam)
    if beam is None and not widths and not edges:
        notes.append(f"no open kerf: the beam is taken as {1e3 * diameter:g} mm wide")
    if beam is not None and widths and abs(_beam(widths, None) - beam) > KERF_DIFFERS:
        wide = 1e3 * _beam(widths, None)
        notes.append(f"the open kerf is {wide:.3f} mm wide, the beam was given as {1e3 * beam:g}")
    contours = dict[str, ScannedContour]()
    scanner = UNCALIBRATED if calibration is None else calibration.residual
    for contour in drawn:
        of = [b for side, b in zip(sides, bins, strict=True) if side.contour is contour]
        contours[contour.name], left_out = _scanned(
            contour, of, 0.0 if edges else diameter, scanner
        )
        if left_out:
            notes.append(left_out)
    scale, said = _scale(drawn, contours, calibration)
    return SheetScan(
        contours=contours,
        placement=(pose.x, pose.y, pose.angle),
        beam=diameter,
        beam_measured=measured,
        scale=scale,
        notes=tuple(Note(cause=Cause.SCAN, text=text) for text in [*notes, *said]),
    )


class _Side(NamedTuple):
    contour: DrawnContour
    sign: int
    """1 if it lies outwards of the contour, -1 inwards."""
    edge: Edge


class _Bins(NamedTuple):
    """Edge in bins of `BIN` along a contour; NaN where there is none."""

    arc_length: Array
    offset: Array
    """(M,) [m], outwards from the contour."""

    @property
    def slant(self) -> Array:
        """(M,), width across the contour over that across the edge, at an angle to it."""
        slope = np.nan_to_num(np.gradient(self.offset, self.arc_length))
        return np.sqrt(1.0 + np.clip(slope, -0.5, 0.5) ** 2)


def _check(sides: Sequence[_Side]) -> None:
    """Raise ValueError for edges that are no sharp, whole and plainly exposed ones."""
    polarity = dict[int, str]()
    for contour, _, edge in sides:
        if edge.beyond > 0.0:
            raise ValueError(f"{contour.name} is cut off by the rim of the image")
        if not len(edge.points):
            raise ValueError(f"{contour.name} has no edge where it should be")
        if edge.white > WHITE:
            raise ValueError(
                f"it is over-exposed: {100 * edge.white:.0f} % of the bright side of "
                f"{contour.name} is white (255); scan it darker"
            )
        if edge.spread > BLURRED:
            raise ValueError(
                f"{contour.name} is blurred by {1e6 * edge.spread:.0f} um (standard deviation); "
                f"at most {1e6 * BLURRED:.0f}: scan it flat, sharp and not scaled up"
            )
        # Inside of a hole, of a kerf and outside of a piece lies the ground.
        inwards = 1 if contour.seen is Seen.KERF else contour.seen.value
        polarity.setdefault(inwards * int(np.sign(edge.inside - edge.outside)), contour.name)
    if len(polarity) > 1:
        raise ValueError(f"{' and '.join(polarity.values())} are of opposite greys: not one sheet")


def _binned(side: _Side, points: Array) -> _Bins:
    """Mean of the points (N, 2) [m] in each bin, of those near their median."""
    curve = side.contour.curve
    s = curve.nearest(points)
    normal = outward_normal(curve.tangent(s))
    d = np.einsum("ij,ij->i", points - curve.point(s), normal)
    # Beside a corner the foot stays on it, and the distance is that from the corner.
    d = np.copysign(np.linalg.norm(points - curve.point(s), axis=1), d)
    inside = np.abs(d) < WINDOW + FARTHEST
    s, d = s[inside], d[inside]
    n = max(8, round(curve.length / BIN))
    at = np.minimum((s / curve.length * n).astype(int), n - 1)
    order = np.lexsort((d, at))
    at, d = at[order], d[order]
    count = np.bincount(at, minlength=n)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    median = d[np.minimum(first + count // 2, len(d) - 1)] if len(d) else np.zeros(n)
    near = np.abs(d - median[at]) < TOGETHER
    kept = np.bincount(at[near], minlength=n)
    total = np.bincount(at[near], weights=d[near], minlength=n)
    good = (kept >= 3) & (kept >= 0.6 * count)
    centre = (np.arange(n) + 0.5) * curve.length / n
    if side.contour.seen is Seen.KERF:  # its round ends belong to neither side
        good &= (centre > ENDS) & (centre < curve.length - ENDS)
    offset = np.where(good, total / np.maximum(kept, 1), np.nan)
    return _Bins(centre, offset)


def _kerfs(sides: Sequence[_Side], bins: Sequence[_Bins]) -> list[Array]:
    """Widths (M,) [m] of each open kerf."""
    found = list[Array]()
    for side, outer, inner in zip(sides, bins, bins[1:], strict=False):
        if side.contour.seen is Seen.KERF and side.sign > 0:
            middle = _Bins(outer.arc_length, 0.5 * (outer.offset + inner.offset))
            width = (outer.offset - inner.offset) / middle.slant
            found.append(width[np.isfinite(width)])
    return [width for width in found if len(width)]


def _beam(widths: Sequence[Array], given: float | None) -> float:
    if given is not None:
        return given
    return float(np.median(np.concatenate(widths))) if widths else BEAM


def _step(
    pose: Pose, sides: Sequence[_Side], bins: Sequence[_Bins], half: float, edges: bool
) -> Array:
    """Motion of the drawing in the image that fits all contours."""
    lever, normals, off = list[Array](), list[Array](), list[Array]()
    for side, of in zip(sides, bins, strict=True):
        beside = 0.0 if edges and side.contour.seen is not Seen.KERF else half
        d = of.offset - side.sign * beside * of.slant
        good = np.isfinite(d) & ~_outlying(d, side.contour.seen is not Seen.KERF)
        s, curve = of.arc_length[good], side.contour.curve
        normals.append(outward_normal(curve.tangent(s)) @ pose.matrix.T)
        lever.append(curve.point(s) @ pose.matrix.T)
        off.append(d[good])
    return rigid_step(np.vstack(lever), np.vstack(normals), np.concatenate(off))


def _scanned(
    contour: DrawnContour, sides: Sequence[_Bins], beam: float, scanner: float
) -> tuple[ScannedContour, str]:
    """Deviation of one contour, and a note of what was left out."""
    is_kerf = contour.seen is Seen.KERF
    if is_kerf:
        d = 0.5 * (sides[0].offset + sides[1].offset)
    else:
        d = sides[0].offset - 0.5 * beam * contour.seen.value * sides[0].slant
    s = sides[0].arc_length
    good = np.isfinite(d) & ~_outlying(d, not is_kerf)
    expected = (s > ENDS) & (s < contour.curve.length - ENDS) if is_kerf else np.full(len(s), True)
    if good.sum() < COVERED * expected.sum():
        raise ValueError(
            f"{contour.name} is seen along {100 * good.sum() / expected.sum():.0f} % of its length "
            f"only; at least {100 * COVERED:.0f} % is wanted"
        )
    if (rms := np.sqrt(np.mean(d[good] ** 2))) > FOUND:
        raise ValueError(f"{contour.name} is off by {1e3 * rms:.2f} mm RMS: another drawing")
    second = d[1:-1] - 0.5 * (d[:-2] + d[2:])
    second = second[good[1:-1] & good[:-2] & good[2:]]
    white = np.sqrt(np.mean(second**2) / 1.5) if len(second) else 0.0
    noise = float(np.sqrt(white**2 + scanner**2 + EDGE**2))
    if white > ROUGH:
        raise ValueError(
            f"{contour.name} is rough: {1e6 * white:.0f} um RMS from bin to bin; at most "
            f"{1e6 * ROUGH:.0f} um of a clean cut are read"
        )
    missing = int(expected.sum() - good.sum())
    note = ""
    if missing > 0:
        lost = missing * contour.curve.length / len(s)
        note = (
            f"{contour.name}: {1e3 * lost:.1f} of {1e3 * contour.curve.length:.1f} mm are left "
            "out: torn, burred or covered"
        )
    return ScannedContour(arc_length=s[good], deviation=d[good], noise=noise), note


def _outlying(d: Array, closed: bool) -> NDArray[np.bool_]:
    """Bins off the smooth course of their neighbours, found again without the first ones."""
    found = _off_course(d, closed)
    return found | _off_course(np.where(found, np.nan, d), closed)


def _off_course(d: Array, closed: bool) -> NDArray[np.bool_]:
    """Bins off a robust polynomial of the fourth degree of `NEIGHBOURS` on each side."""
    n, half = len(d), min(NEIGHBOURS, len(d) // 2 - 1)
    x = np.arange(-half, half + 1)
    i = np.arange(n)[:, np.newaxis] + x
    window = d[i % n] if closed else np.where((i >= 0) & (i < n), d[np.clip(i, 0, n - 1)], np.nan)
    there = np.isfinite(window)
    window = np.where(there, window, 0.0)
    basis = (x[:, np.newaxis] / half) ** np.arange(DEGREE + 1)
    weight, residual, size = there.astype(np.float64), window, np.full(n, OUTLYING)
    for step in range(10):
        A = np.einsum("nk,kp,kq->npq", weight, basis, basis) + 1e-9 * np.eye(DEGREE + 1)
        b = np.einsum("nk,nk,kp->np", weight, window, basis)
        residual = window - np.linalg.solve(A, b[..., np.newaxis])[..., 0] @ basis.T
        away = np.abs(residual)
        masked = np.where(there, away, np.nan)
        with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # empty windows
            size = np.fmax(OUTLYING, 6.0 * 1.48 * np.nanmedian(masked, axis=1))
        if step < 6:  # absolute values first, which a tear does not pull along
            weight = there * 5e-6 / np.maximum(away, 5e-6)
        else:
            weight = there * (1.0 - np.minimum(away / size[:, np.newaxis], 1.0) ** 2) ** 2
    return np.abs(residual[:, half]) > size


def _scale(
    drawn: Sequence[DrawnContour],
    contours: Mapping[str, ScannedContour],
    calibration: Calibration | None,
) -> tuple[float, list[str]]:
    """Standard deviation of the scale, and what to say. Of a scanner that is not calibrated nobody
    knows whether it or the robot is too large; a calibration is believed."""
    points, normals, d = list[Array](), list[Array](), list[Array]()
    for contour in drawn:
        of = contours[contour.name]
        points.append(contour.curve.point(of.arc_length))
        normals.append(outward_normal(contour.curve.tangent(of.arc_length)))
        d.append(of.deviation)
    at, normal, off = np.vstack(points), np.vstack(normals), np.concatenate(d)
    at = at - at.mean(axis=0)
    along = at * normal
    turned = at[:, 0] * normal[:, 1] - at[:, 1] * normal[:, 0]
    size = np.abs(at).max()
    J = np.column_stack([normal, turned / size, along / size])
    fitted = np.linalg.lstsq(J, off, rcond=1e-6)[0][3:] / size
    scale = SCALE if calibration is None else calibration.scale
    said = [] if calibration else ["the scanner is not calibrated: sizes are off by its scale"]
    if size > WIDE and np.abs(fitted).max() > SCALED:
        most = float(fitted[np.abs(fitted).argmax()])
        larger = "larger" if most > 0.0 else "smaller"
        whose = "the cut's, as the scanner is calibrated"
        if calibration is None:
            whose, scale = "the scanner's error or the cut's", max(scale, abs(most))
        said.append(f"the sheet is {100 * abs(most):.2f} % {larger} than drawn: {whose}")
    return scale, said
