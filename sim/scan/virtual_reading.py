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
from ..evaluation.tool_error import STEPS
from ..motion.contour import ClosedCurve, outward_normal
from .reading import ScannedContour, SheetScan

BIN = 0.2e-3
"""[m], of the arc length."""


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
    direction: float = 0.0
    """Width of a kerf cut clockwise less that of one cut the other way round [m], not drawn."""
    drift: float = 0.0
    """Width of the last kerf less that of the first [m], not drawn: two thirds of it steadily."""


CALIBRATED = ScanErrors()
"""By a glass grid."""
UNCALIBRATED = ScanErrors(scale=1e-3, skew=5e-4, wobble=(10e-6, 30e-6))
CHEAP = ScanErrors(scale=6e-3, skew=5e-4, wobble=(30e-6, 30e-6))
"""Scale as discuss.pixls.us 29481 has of an Epson V200."""


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
    beam: float = 0.2e-3,
    beam_measured: bool = True,
) -> SheetScan:
    """The reading of a sheet, its contours in the order in which they were cut.

    beam: diameter [m] that is taken off. beam_measured: an open kerf shows the diameter.
    """
    width = 0.0 if beam_measured else errors.beam * rng.standard_normal()
    scale = errors.scale * rng.standard_normal(2)
    skew = errors.skew * rng.standard_normal()
    wobble = _wobble(rng, errors)
    placed, place = placement([(one.curve, one.middle, one.path) for one in cut.values()])
    drift = _drift(rng, len(cut), errors.drift)
    found = dict[str, tuple[Array, Array]]()
    for i, (name, one) in enumerate(cut.items()):
        edge = kerf(one.curve, placed[i] - one.middle, beam, closed=False)
        seen = np.isfinite(edge.outer)
        s, d = _binned(edge.arc_length[seen], edge.outer[seen] - 0.5 * beam)
        normal = _normals(one.curve, s)
        at = one.curve.point(s) + one.middle
        half = width + errors.from_cut_to_cut * rng.standard_normal()
        half += drift[i] + (0.5 if one.clockwise else -0.5) * errors.direction
        moved = at * scale + np.column_stack([skew * at[:, 1], np.zeros(len(at))]) + wobble(at)
        d = d + 0.5 * half + np.einsum("ij,ij->i", normal, moved)
        d += _correlated(rng, s, errors.edge, errors.edge_correlation)
        white = np.hypot(errors.roughness * np.sqrt(0.5), errors.image)
        found[name] = s, d + white * rng.standard_normal(len(s))
    shapes = [
        (one.curve, one.middle, one.curve.point(s) + d[:, None] * _normals(one.curve, s) + one.middle)
        for one, (s, d) in zip(cut.values(), found.values(), strict=True)
    ]
    again, second = placement(shapes)
    noise = float(np.hypot(errors.edge, white))
    contours = {
        name: ScannedContour(arc_length=s, deviation=_across(one, points), noise=noise)
        for (name, (s, _)), one, points in zip(found.items(), cut.values(), again, strict=True)
    }
    x, y, angle = place + second
    return SheetScan(
        contours=contours,
        placement=(float(x), float(y), float(angle)),
        beam=beam,
        beam_measured=beam_measured,
        scale=errors.scale,
    )


def placement(
    sheet: Sequence[tuple[ClosedCurve, tuple[float, float], Array]],
) -> tuple[list[Array], Array]:
    """Points (N, 2) of each contour after the rigid motion that fits all of them to the drawing
    together, by Gauss-Newton; and what places the drawing there, x, y [m] and angle [rad].

    sheet: of each contour its curve, its middle on the drawing, and its points [m].
    """
    points = [np.array(each, dtype=np.float64) for _, _, each in sheet]
    rotation, shift = np.eye(2), np.zeros(2)
    for _ in range(STEPS):
        rows, right = [], []
        for (curve, middle, _), p in zip(sheet, points, strict=True):
            s = curve.nearest(p - middle)
            normal = _normals(curve, s)
            lever = p[:, 0] * normal[:, 1] - p[:, 1] * normal[:, 0]
            rows.append(np.column_stack([normal, lever]) / np.sqrt(len(p)))
            off = np.einsum("ij,ij->i", p - middle - curve.point(s), normal)
            right.append(-off / np.sqrt(len(p)))
        step, *_ = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=1e-6)
        c, s = np.cos(step[2]), np.sin(step[2])
        turn = np.array([[c, -s], [s, c]])
        points = [p @ turn.T + step[:2] for p in points]
        rotation, shift = turn @ rotation, turn @ shift + step[:2]
        if np.abs(step).max() < 1e-12:
            break
    back = -rotation.T @ shift
    return points, np.array([*back, -np.arctan2(rotation[1, 0], rotation[0, 0])])


def _across(one: BeamPath, points: Array) -> Array:
    """(N,) [m], signed distance of placed points from the drawn contour."""
    p = points - one.middle
    s = one.curve.nearest(p)
    return np.asarray(np.einsum("ij,ij->i", p - one.curve.point(s), _normals(one.curve, s)))


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


def _drift(rng: np.random.Generator, n: int, size: float) -> Array:
    """(n,) [m], of the width of each kerf: two thirds steady, one third a random walk."""
    steady = np.linspace(-0.5, 0.5, n) * 2.0 / 3.0
    return size * (steady + rng.standard_normal(n).cumsum() / np.sqrt(n) / 3.0)
