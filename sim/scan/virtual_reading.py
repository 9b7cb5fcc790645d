"""A scan of a sheet as a scanner would read it, drawn from the true path of the beam.

No image: the edge of the area that the beam swept, with errors of cut and scanner added, as the
image chain reads it. All numbers are ESTIMATES of `shared/scan-trial.md`, whose noise of the chain
against images they reproduce, unless a source stands beside them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..evaluation.kerf import kerf
from ..evaluation.tool_error import CONVERGED, STEPS, signed_distance
from ..motion.contour import ClosedCurve, outward_normal
from ..notes import Cause, Note
from .placement import Pose, rigid_step
from .reading import BEAM, BIN, SCALE, SCALED, ScannedContour, SheetScan


@dataclass(frozen=True, kw_only=True)
class ScanErrors:
    """Errors of cut and scanner, standard deviations in SI units: those of a calibrated CCD."""

    beam: float = 5e-6
    """Of the diameter from that assumed; nothing where an open kerf shows it."""
    from_cut_to_cut: float = 2e-6
    edge: float = 3e-6
    edge_correlation: float = 3e-3
    roughness: float = 4e-6
    """Correlated over half a bin."""
    image: float = 1.2e-6
    """Of a bin."""
    scale: float = 1e-4
    """Of each direction, a ratio."""
    skew: float = 5e-5
    """[rad]."""
    wobble: tuple[float, float] = (2e-6, 4e-6)
    """Range of the peak of the carriage's wobble along y; 30 % of it is sideways."""
    calibrated: bool = True
    """The scanner has been calibrated, and its reader knows."""
    direction: float = 0.0
    """Width of a kerf cut clockwise less that of one cut the other way round [m], not drawn."""
    drift: float = 0.0
    """Width of the last kerf less that of the first [m], not drawn; a third of it walks."""


CALIBRATED = ScanErrors()
"""By a glass grid."""
UNCALIBRATED = ScanErrors(calibrated=False, scale=1e-3, skew=5e-4, wobble=(10e-6, 30e-6))
CHEAP = ScanErrors(calibrated=False, scale=6e-3, skew=5e-4, wobble=(30e-6, 30e-6))
"""Scale as discuss.pixls.us 29481 has of an Epson V200."""


_SAID = "the scanner is not calibrated: sizes are off by its scale"


@dataclass(frozen=True, kw_only=True)
class BeamPath:
    """One contour on a sheet, and where the beam was."""

    curve: ClosedCurve
    """As drawn, counter-clockwise around its middle."""
    middle: tuple[float, float]
    """(2,) [m], on the drawing."""
    path: Array
    """(N, 2) [m], centre of the beam, in the coordinates of the drawing but for a placement."""
    clockwise: bool = False


def virtual_scan(
    cut: Mapping[str, BeamPath],
    rng: np.random.Generator,
    errors: ScanErrors = CALIBRATED,
    *,
    unit: np.random.Generator | None = None,
    beam: float = BEAM,
    beam_measured: bool = True,
) -> SheetScan:
    """The reading of a sheet, its contours in the order in which they were cut.

    rng: of what differs from part to part. unit: of scanner and beam, which stay; `rng` if None.
    beam: diameter [m] that is taken off. beam_measured: an open kerf shows the diameter.
    """
    unit = unit or rng
    width = 0.0 if beam_measured else errors.beam * unit.standard_normal()
    scale = errors.scale * unit.standard_normal(2)
    skew = errors.skew * unit.standard_normal()
    wobble = _wobble(unit, errors)
    placed, _ = placement([(one.curve, one.middle, one.path) for one in cut.values()])
    drift = _drift(rng, len(cut), errors.drift)
    found, white = dict[str, Array](), 0.0
    for i, (name, one) in enumerate(cut.items()):
        edge = kerf(one.curve, placed[i] - one.middle, beam, closed=False)
        seen = np.isfinite(edge.outer)
        s, d = _binned(edge.arc_length[seen], edge.outer[seen] - 0.5 * beam)
        normal = _normals(one.curve, s)
        at = one.curve.point(s) + one.middle
        half = width + errors.from_cut_to_cut * rng.standard_normal()
        half += drift[i] + (0.5 if one.clockwise else -0.5) * errors.direction
        d = d + 0.5 * half + _correlated(rng, s, errors.edge, errors.edge_correlation)
        white = np.hypot(errors.roughness * np.sqrt(0.5), errors.image)
        d += white * rng.standard_normal(len(s))
        seen_at = at + d[:, None] * normal
        skewed = np.column_stack([skew * seen_at[:, 1], np.zeros(len(at))])
        found[name] = seen_at * (1.0 + scale) + skewed + wobble(seen_at)
    again, pose = placement([(one.curve, one.middle, found[name]) for name, one in cut.items()])
    noise = float(np.hypot(errors.edge, white))
    contours = {
        name: _read(one, points, noise)
        for (name, one), points in zip(cut.items(), again, strict=True)
    }
    return SheetScan(
        contours=contours,
        placement=(pose.x, pose.y, pose.angle),
        beam=beam,
        beam_measured=beam_measured,
        scale=_stated(again, cut, errors.calibrated),
        notes=() if errors.calibrated else (Note(cause=Cause.SCAN, text=_SAID),),
    )


def placement(
    sheet: Sequence[tuple[ClosedCurve, tuple[float, float], Array]],
) -> tuple[list[Array], Pose]:
    """Points (N, 2) of each contour after the rigid motion that fits all of them to the drawing
    together, by Gauss-Newton; and where the drawing was among them.

    sheet: of each contour its curve, its middle on the drawing, and its points [m].
    """
    points = [np.array(each, dtype=np.float64) for _, _, each in sheet]
    drawn = [curve.point(np.linspace(0.0, curve.length, 100)) + at for curve, at, _ in sheet]
    # From middle to middle: one that lies a good part of its size away would turn by a corner.
    x, y = np.mean([p.mean(axis=0) - q.mean(axis=0) for p, q in zip(points, drawn, strict=True)], 0)
    pose = Pose(float(x), float(y), 0.0)
    for _ in range(STEPS):
        normals, off, at = list[Array](), list[Array](), list[Array]()
        for (curve, middle, _), each in zip(sheet, points, strict=True):
            p = pose.to_drawing(each)
            s = curve.nearest(p - middle)
            normals.append(_normals(curve, s) @ pose.matrix.T)
            off.append(signed_distance(curve, p - middle))
            at.append(p @ pose.matrix.T)
        step = rigid_step(np.vstack(at), np.vstack(normals), np.concatenate(off))
        pose = pose.moved(step)
        if np.abs(step).max() < CONVERGED:
            break
    return [pose.to_drawing(each) for each in points], pose


def _read(one: BeamPath, points: Array, noise: float) -> ScannedContour:
    p = points - one.middle
    s, d = one.curve.nearest(p), signed_distance(one.curve, p)
    order = np.argsort(s)
    return ScannedContour(arc_length=s[order], deviation=d[order], noise=noise)


def _normals(curve: ClosedCurve, s: Array) -> Array:
    return outward_normal(curve.tangent(s))


def _binned(s: Array, d: Array) -> tuple[Array, Array]:
    """Means of values in bins of the arc length."""
    number = (s / BIN).astype(int)
    first, inverse, count = np.unique(number, return_inverse=True, return_counts=True)[:3]
    assert len(first) == len(count)
    return np.bincount(inverse, s) / count, np.bincount(inverse, d) / count


def _correlated(rng: np.random.Generator, s: Array, size: float, length: float) -> Array:
    """Noise at arc lengths (N,), ascending, exponentially correlated over a length."""
    white, value = rng.standard_normal(len(s)), np.empty(len(s))
    rho = np.exp(-np.diff(s, prepend=s[:1]) / length)
    for i, (r, w) in enumerate(zip(rho, white, strict=True)):
        value[i] = w if i == 0 else r * value[i - 1] + np.sqrt(1.0 - r**2) * w
    return size * value


def _wobble(rng: np.random.Generator, errors: ScanErrors) -> Callable[[Array], Array]:
    peak = rng.uniform(*errors.wobble)
    period, phase = rng.uniform(5e-3, 20e-3, 3), rng.uniform(0.0, 2.0 * np.pi, (2, 3))

    def at(p: Array) -> Array:
        """(N, 2) [m]; three sines, sideways 30 % of that along y."""
        along = 2.0 * np.pi * p[:, 1:] / period
        return np.column_stack(
            [
                0.3 * peak / 3.0 * np.sin(along + phase[0]).sum(axis=1),
                peak / 3.0 * np.sin(along + phase[1]).sum(axis=1),
            ]
        )

    return at


def _stated(placed: Sequence[Array], cut: Mapping[str, BeamPath], calibrated: bool) -> float:
    """Standard deviation of the scale as a reader states it, who sees the contours alone."""
    if calibrated:
        return CALIBRATED.scale
    rows, off = list[Array](), list[Array]()
    for one, points in zip(cut.values(), placed, strict=True):
        p = points - one.middle
        n = _normals(one.curve, one.curve.nearest(p))
        turned = points[:, 0] * n[:, 1] - points[:, 1] * n[:, 0]
        rows.append(np.column_stack([n, turned, n * points]))
        off.append(signed_distance(one.curve, p))
    fitted = np.linalg.lstsq(np.vstack(rows), np.concatenate(off), rcond=1e-9)[0][3:]
    largest = float(np.abs(fitted).max())
    return max(SCALE, largest) if largest > SCALED else SCALE


def _drift(rng: np.random.Generator, n: int, size: float) -> Array:
    """(n,) [m], of the width of each kerf: steady, and a random walk of a third."""
    steady = np.linspace(-0.5, 0.5, n)
    return size * (steady + rng.standard_normal(n).cumsum() / np.sqrt(n) / 3.0)
