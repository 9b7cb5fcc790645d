"""Calibration of a scanner by a grid of lines of known pitch: scale, skew, wobble of its carriage.

The grid lies turned by some degrees, so that its lines cross every height of the bed.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..records.files import check_file, reading
from .image import Outline, ScanImage, edge_near, kerf_near, outlines, read_image

SAME = 0.05e-3
"""Largest difference between the scanned areas of grid and sheet [m]: a pixel of 600 dpi. Heights
count from the lower rim, so that it moves the wobble."""
KNOTS = 1.25e-3
"""Distance of the places at which the wobble is known [m]: four to the shortest period."""
BIN = 0.5e-3
"""Length of line that is one value [m]."""
WOBBLE = 20e-6
"""Standard deviation of the wobble, and of its bends from knot to knot [m]. ESTIMATE"""
NOISE = 3e-6
"""Standard deviation of one value [m]. ESTIMATE"""
HEIGHTS = 0.8
"""Least part of the heights that lines across the carriage's way have to pass."""
LEFT = 12e-6
"""Largest RMS that a grid may leave [m]: twice that of a scanner that nobody calibrated."""
FOLD = 15e-6
"""Largest median residual on a strip of the bed `STRIP` wide [m]."""
STRIP = 3e-3
CELLS = 16
"""Least number of whole cells of a grid."""
VERSION = 1


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Errors of a scanner, over the area that it scans.

    A point of the image at (x, y) is seen where A (x, y) + w(y) lies on the glass, about the middle
    of the area.
    """

    matrix: Array
    """(2, 2), A: scale in x and y, and skew; its lower left element is 0."""
    y: Array
    """(K,) [m], in the image, at which the wobble is known; between them it is a cubic spline."""
    wobble: Array
    """(K, 2) [m], w in x and y."""
    area: tuple[float, float]
    """Width and height [m] of the image."""
    residual: float
    """RMS [m] that is left of the grid."""
    scale: float = 1e-4
    """Standard deviation of the scale: that of the grid. ESTIMATE"""
    gamma: float | None = None
    """Of the greys of its files; None where each file says its own."""

    def check(self, image: ScanImage) -> None:
        """Raise ValueError for an image of another area: the wobble belongs to the place."""
        if max(abs(a - b) for a, b in zip(image.size, self.area, strict=True)) > SAME:
            given, own = (f"{1e3 * w:.1f} x {1e3 * h:.1f} mm" for w, h in (image.size, self.area))
            raise ValueError(f"it shows {given}, the calibration {own}: scan the same area")

    def corrected(self, points: Array) -> Array:
        """Points (N, 2) [m] of an image, where they lie on the glass.

        Raises ValueError for points above or below the grid, where nothing is known.
        """
        from scipy.interpolate import CubicSpline

        y, beyond = points[:, 1], 2.0 * KNOTS
        if len(y) and (y.min() < self.y[0] - beyond or y.max() > self.y[-1] + beyond):
            at, to = (f"{1e3 * v.min():.0f} to {1e3 * v.max():.0f} mm" for v in (y, self.y))
            raise ValueError(f"the sheet lies at heights {at}, the grid lay at {to}")
        middle = 0.5 * np.array(self.area)
        wobble = CubicSpline(self.y, self.wobble)(np.clip(y, self.y[0], self.y[-1]))
        return middle + (points - middle) @ self.matrix.T + wobble

    def as_json(self) -> dict[str, Any]:
        """Entries of `scanner.json`, in SI units."""
        entries = {name: np.asarray(getattr(self, name)).tolist() for name in FIELDS}
        return {"armside_scanner": VERSION, **entries, "gamma": self.gamma}


FIELDS = ("matrix", "y", "wobble", "area", "residual", "scale")


FILE = "scanner.json"


def read_calibration(file: Path) -> Calibration:
    """Calibration of a file that `Calibration.as_json` was written to, or of the folder with it.

    Raises ValueError for any other file.
    """
    file = file / FILE if file.is_dir() else file
    check_file(file)
    with reading(file):
        data = json.loads(file.read_text(encoding="utf-8"))
        if not isinstance(data, Mapping) or data.get("armside_scanner") != VERSION:
            raise ValueError("it is no scanner.json of `armside scan calibrate`")
        found = {name: np.array(data[name], dtype=np.float64) for name in FIELDS}
        k = len(found["y"]) if found["y"].ndim == 1 else 0
        shapes = {"matrix": (2, 2), "y": (k,), "wobble": (k, 2), "area": (2,)}
        for name, value in found.items():
            if value.shape != shapes.get(name, ()) or not np.isfinite(value).all():
                raise ValueError(f"its {name} is not {shapes.get(name, ())} finite numbers")
        if k < 4 or not (np.diff(found["y"]) > 0.0).all():
            raise ValueError("its heights y must increase, four or more")
        width, height = found["area"].tolist()
        gamma = data.get("gamma")
        if gamma is not None and not (isinstance(gamma, float | int) and 0.0 < gamma < np.inf):
            raise ValueError("its gamma is no number above 0")
        return Calibration(
            matrix=found["matrix"],
            y=found["y"],
            wobble=found["wobble"],
            area=(width, height),
            residual=float(found["residual"]),
            scale=float(found["scale"]),
            gamma=gamma,
        )


def image_by(calibration: Calibration | None, file: Path, dpi: float | None = None) -> ScanImage:
    """Image of a scanner that may be calibrated. Raises as `read_image`."""
    return read_image(file, dpi, None if calibration is None else calibration.gamma)


@dataclass(frozen=True, eq=False)
class _Lines:
    """Middles of a grid's lines in one image."""

    points: Array
    """(N, 2) [m]."""
    family: NDArray[np.int64]
    """(N,), 0 for the lines across the grid's x, 1 for those across its y."""
    index: NDArray[np.int64]
    """(N,), number of the line."""
    angle: float
    """[rad], of the grid."""


def calibrated(images: Sequence[ScanImage], pitch: float) -> Calibration:
    """Calibration by one or more scans of a grid of lines `pitch` [m] apart, turned differently.

    Raises ValueError for images without such a grid, for one that lies too straight, and for a
    scanner that bends its image along the carriage, as contact image sensors do.
    """
    if not 2e-3 <= pitch <= 20e-3:
        raise ValueError(f"the pitch must be 2 to 20 mm, got {1e3 * pitch:g}")
    area = images[0].size
    for image in images[1:]:
        if max(abs(a - b) for a, b in zip(image.size, area, strict=True)) > SAME:
            raise ValueError(f"{image.name} shows another area than {images[0].name}")
    lines = [_lines(image, pitch) for image in images]
    knots = _knots(lines)
    _check_heights(lines, knots)
    middle = 0.5 * np.array(area)
    x, residual, good = _solved(lines, pitch, knots, middle)
    _check_left(lines, residual, good)
    n = len(knots) + 2
    sx, sy, skew = x[:3]
    table = _design(knots, knots) @ x[3 : 3 + 2 * n].reshape(2, n).T
    return Calibration(
        matrix=np.array([[1.0 + sx, skew], [0.0, 1.0 + sy]]),
        y=knots,
        wobble=table,
        area=area,
        residual=float(np.sqrt(np.mean(residual[good] ** 2))),
    )


def _lines(image: ScanImage, pitch: float) -> _Lines:
    """Middles of the lines, from both of their edges."""
    cells = [c for c in outlines(image, 2.0 * pitch) if 0.5 < c.area / pitch**2 < 1.05]
    if len(cells) < CELLS:
        raise ValueError(
            f"{image.name} has {len(cells)} whole cells of {1e3 * pitch:g} mm; at least {CELLS} "
            "are wanted"
        )
    angle, affine, index = _lattice(image, cells, pitch)
    width = max(np.linalg.norm(affine[0]) - np.sqrt(np.median([c.area for c in cells])), 0.03e-3)
    found = list[tuple[Array, int, int]]()
    for family in (0, 1):
        first, last = index.min(axis=0) - 0.5, index.max(axis=0) + 0.5
        for k in np.arange(first[family] + 1.0, last[family]):
            n = int((last - first)[1 - family] * pitch / 0.1e-3)
            at = np.full((n, 2), k)
            at[:, 1 - family] = np.linspace(first[1 - family], last[1 - family], n)
            # Where it has a cell on both sides.
            beside = [np.rint(at + np.eye(2)[family] * side).astype(int) for side in (-0.4, 0.4)]
            every = {tuple(i) for i in index.tolist()}
            whole = [all(tuple(b[i].tolist()) in every for b in beside) for i in range(n)]
            crossing = np.abs(at[:, 1 - family] % 1.0 - 0.5) * pitch < 0.5 * width + 0.15e-3
            points = affine[2] + at @ affine[:2]
            normal = affine[family] / np.linalg.norm(affine[family])
            for middle in _middles(image, points, normal, width, np.array(whole) & ~crossing):
                found.append((middle, family, int(k + 0.5)))
    if not found:
        raise ValueError(f"{image.name}: its grid has no lines that can be read")
    points, families, indices = zip(*found, strict=True)
    return _Lines(np.array(points), np.array(families), np.array(indices), angle)


def _lattice(
    image: ScanImage, cells: Sequence[Outline], pitch: float
) -> tuple[float, Array, NDArray[np.int64]]:
    """Angle [rad] of a grid, rows (3, 2) of the affine map from cells to the image [m], and the
    place (N, 2) of each cell."""
    from scipy.spatial import KDTree

    middle = np.array([cell.middle for cell in cells])
    i, j = KDTree(middle).query_pairs(1.1 * pitch, output_type="ndarray").T
    apart = middle[j] - middle[i]
    apart = apart[np.abs(np.linalg.norm(apart, axis=1) / pitch - 1.0) < 0.05]
    if len(apart) < CELLS:
        raise ValueError(f"{image.name}: its cells are not {1e3 * pitch:g} mm apart")
    angle = float(np.angle(np.exp(4j * np.arctan2(apart[:, 1], apart[:, 0])).mean())) / 4.0
    c, s = np.cos(angle), np.sin(angle)
    affine: Array = np.vstack([pitch * np.array([[c, s], [-s, c]]), middle[len(middle) // 2]])
    index, off = np.zeros((len(middle), 2), dtype=np.int64), np.zeros(len(middle))
    for _ in range(3):
        index = np.rint((middle - affine[2]) @ np.linalg.inv(affine[:2])).astype(np.int64)
        J = np.column_stack([index, np.ones(len(index))])
        affine = np.asarray(np.linalg.lstsq(J, middle, rcond=None)[0], dtype=np.float64)
        off = np.linalg.norm(J @ affine - middle, axis=1)
    if np.median(off) > 0.05 * pitch or len(np.unique(index, axis=0)) < len(index):
        raise ValueError(f"{image.name}: its cells form no grid of {1e3 * pitch:g} mm")
    return angle, affine, index


def _middles(
    image: ScanImage, points: Array, normal: Array, width: float, used: NDArray[np.bool_]
) -> Array:
    """Middles (M, 2) [m] of a line in bins, of both of its edges."""
    n = max(1, int(np.ceil(np.linalg.norm(points[-1] - points[0]) / BIN)))
    means = list[Array]()
    keep = np.repeat(False, n)
    origin = points[0]
    step = (points[-1] - points[0]) / n
    at = np.clip(((points - origin) @ step / (step @ step)).astype(int), 0, n - 1)
    share = np.bincount(at, weights=used, minlength=n) / np.maximum(np.bincount(at, minlength=n), 1)
    keep = share > 0.99
    beside = kerf_near(image, points, np.tile(normal, (len(points), 1)))[0][:, np.newaxis] * normal
    for side in (1.0, -1.0):
        out = np.tile(side * normal, (len(points), 1))
        edge = edge_near(image, points + beside + 0.5 * width * out, out, narrow=0.5 * width).points
        i = np.floor((edge - origin) @ step / (step @ step)).astype(int)
        across = (edge - origin) @ normal
        inside = (i >= 0) & (i < n) & (np.abs(across - 0.5 * side * width) < 0.2e-3)
        i, across = i[inside], across[inside]
        count = np.bincount(i, minlength=n)
        keep &= count >= 5
        means.append(np.bincount(i, weights=across, minlength=n) / np.maximum(count, 1))
    middle, wide = 0.5 * (means[0] + means[1]), means[0] - means[1]
    if keep.any():
        keep &= np.abs(wide - np.median(wide[keep])) < 20e-6
    centre = origin + (np.arange(n) + 0.5)[:, np.newaxis] * step
    # The bins' centres lie on the expected line, which `normal` need not be square to.
    centre = centre - ((centre - origin) @ normal)[:, np.newaxis] * normal
    return (centre + middle[:, np.newaxis] * normal)[keep]


def _knots(lines: Sequence[_Lines]) -> Array:
    heights = np.concatenate([each.points[:, 1] for each in lines])
    low, high = heights.min(), heights.max()
    return np.linspace(low, high, max(6, round((high - low) / KNOTS) + 1))


def _design(y: Array, knots: Array) -> Any:
    """Sparse (N, K + 2) values of cubic B-splines at heights."""
    from scipy.interpolate import BSpline

    step = knots[1] - knots[0]
    extended = knots[0] + step * np.arange(-3, len(knots) + 3)
    inside = np.clip(y, knots[0], knots[-1] - 1e-9 * step)
    return BSpline.design_matrix(inside, extended, 3)


def _check_heights(lines: Sequence[_Lines], knots: Array) -> None:
    """Raise ValueError where the wobble would not be seen: that along y shows on lines across y."""
    seen = np.zeros(len(knots) - 1)
    for each in lines:
        across_y = np.abs(_normals(each.angle, each.family)[:, 1]) > 0.7
        seen += np.histogram(each.points[across_y, 1], knots)[0]
    if (part := np.mean(seen > 0)) < HEIGHTS:
        raise ValueError(
            f"the lines pass {100 * part:.0f} % of the heights only: turn the grid by 2 to 10 deg"
        )


def _normals(angle: float, family: NDArray[np.int64]) -> Array:
    """(N, 2), unit vectors across the lines."""
    turned = angle + 0.5 * np.pi * family
    return np.column_stack([np.cos(turned), np.sin(turned)])


def _solved(
    lines: Sequence[_Lines], pitch: float, knots: Array, middle: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Parameters (scale x, scale y, skew, splines of w_x and w_y, and for each image its angle and
    two offsets), residuals (N,) [m] and which of them are used."""
    from scipy.sparse import csr_array, diags_array, hstack, vstack

    n = len(knots) + 2
    x = np.zeros(3 + 2 * n + 3 * len(lines))
    prior = np.zeros((len(x), len(x)))
    second = np.diff(np.eye(n), 2, axis=0)
    bends = (np.eye(n) + second.T @ second) / WOBBLE**2
    for i in (3, 3 + n):
        prior[i : i + n, i : i + n] = bends
    good = np.full(sum(len(each.points) for each in lines), True)
    residual = np.zeros(len(good))
    for step in range(4):
        blocks, off = list[Any](), list[Array]()
        for m, each in enumerate(lines):
            spline = _design(each.points[:, 1], knots)
            p = each.points - middle
            own = x[3 + 2 * n + 3 * m :][:3]
            angle = each.angle + own[0]
            e, turned = (_normals(angle + a, each.family) for a in (0.0, 0.5 * np.pi))
            w = np.column_stack([spline @ x[3 : 3 + n], spline @ x[3 + n : 3 + 2 * n]])
            seen = p + np.column_stack([x[0] * p[:, 0] + x[2] * p[:, 1], x[1] * p[:, 1]]) + w
            r = np.einsum("ij,ij->i", e, seen) - pitch * each.index
            if step == 0:  # offsets from nothing
                for f in (0, 1):
                    own[1 + f] = np.median(r[each.family == f])
            off.append(r - own[1 + each.family])
            linear = [e[:, 0] * p[:, 0], e[:, 1] * p[:, 1], e[:, 0] * p[:, 1]]
            pose = np.zeros((len(p), 3 * len(lines)))
            pose[:, 3 * m] = np.einsum("ij,ij->i", turned, seen)
            pose[np.arange(len(p)), 3 * m + 1 + each.family] = -1.0
            parts = [
                np.column_stack(linear),
                *(diags_array(e[:, i]) @ spline for i in (0, 1)),
                pose,
            ]
            blocks.append(hstack([csr_array(part) for part in parts]))
        residual = np.concatenate(off)
        if step:
            size = 1.48 * np.median(np.abs(residual))
            good = np.abs(residual) < max(6.0 * size, 10e-6)
        J = vstack(blocks).tocsr()[good]
        normal = (J.T @ J).toarray() / NOISE**2 + prior
        # Scales of the unknowns differ by a thousand; a smooth part of w is scale or skew as well.
        unit = 1.0 / np.sqrt(np.diag(normal))
        rhs = -(J.T @ residual[good]) / NOISE**2 - prior @ x
        scaled = normal * unit * unit[:, np.newaxis]
        x = x + unit * np.linalg.lstsq(scaled, unit * rhs, rcond=1e-12)[0]
    return x, residual, good


def _check_left(lines: Sequence[_Lines], residual: Array, good: NDArray[np.bool_]) -> None:
    """Raise ValueError for what no carriage does."""
    rms = np.sqrt(np.mean(residual[good] ** 2))
    points = np.vstack([each.points for each in lines])
    across_x = np.concatenate(
        [np.abs(_normals(each.angle, each.family)[:, 0]) > 0.7 for each in lines]
    )
    strip = (points[across_x, 0] / STRIP).astype(int)
    left = residual[across_x]
    worst, where = 0.0, 0
    for i in np.unique(strip):
        if (strip == i).sum() >= 8 and abs(median := np.median(left[strip == i])) > worst:
            worst, where = abs(median), i
    if worst > FOLD:
        raise ValueError(
            f"the grid leaves {1e6 * worst:.0f} um at x = {1e3 * (where + 0.5) * STRIP:.0f} mm: "
            "folds, as of a contact image sensor (CIS); take a CCD scanner"
        )
    used = good.mean()
    if rms > LEFT or used < 0.8:
        raise ValueError(
            f"the grid leaves {1e6 * rms:.0f} um RMS on {100 * used:.0f} % of its lines; at most "
            f"{1e6 * LEFT:.0f} um on 80 % are accepted"
        )
