"""Grey image of a scanner, and edges in it to a fraction of a pixel.

Image coordinates: [m], x to the right and y up, from the lower left corner of the image.
"""

import warnings
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from armside.arrays import Array

from ..records.files import check_file, reading

if TYPE_CHECKING:
    import skimage as skimage
else:

    class _Skimage:
        """scikit-image, of the extra `scan`: imported where it is first used."""

        def __getattr__(self, name: str) -> Any:
            return import_module(f"skimage.{name}")

    skimage = _Skimage()

INCH = 0.0254
RESOLUTION = (500.0, 10_000.0)
"""[dpi]. Below, a kerf of 0.2 mm is no four pixels wide."""
PIXELS = 600_000_000
"""Most pixels: those of an A4 bed at 2400 dpi, 0.6 GB."""
LARGEST_FILE = 2_000_000_000
"""[bytes]."""
COARSE = 90e-6
"""Largest pixel of the coarse image [m]: half a kerf."""
WINDOW = 0.6e-3
"""Distance from the expected edge within which an edge is searched for [m]."""
PLATEAU = (0.30e-3, 0.55e-3)
"""Distances from the expected edge at which the greys of both sides are taken [m]."""
PIECE = 4e-3
"""Length of edge that is read with one half grey [m]."""
CONTRAST = 30.0
"""Smallest difference of grey between both sides, of 255."""
BLURRED = 50e-6
"""Standard deviation from which the spread of an edge is no scanner's [m]: by this measure 30 um at
600 dpi and 44 at 500 with poor optics, 60 at 200 dpi scaled up."""
ACROSS = 20e-6
"""Step across a kerf that is searched for [m]."""
BESIDE = (80e-6, 110e-6)
"""Distances from a point of the edge at which both sides have their greys [m]; a kerf's is its
middle."""
STAINED = 0.3
"""Largest difference of such a grey from that of its side, over the contrast: dust, dirt."""
TURNED = 0.5
"""Least cosine between an edge's gradient and the normal of the expected edge."""
WHITE = 0.98
"""Part of the bright side at 255 from which it is over-exposed: then half grey is unknown."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ScanImage:
    """Grey image and the size of its pixels."""

    grey: NDArray[np.uint8]
    """(rows, columns), 0 to 255, first row at the top."""
    pixel: tuple[float, float]
    """Width and height of a pixel [m]."""
    name: str = "image"

    def __post_init__(self) -> None:
        low, high = RESOLUTION
        for dpi in self.dpi:
            if not low <= dpi <= high:
                raise ValueError(f"{self.name} has {dpi:g} dpi; {low:g} to {high:g} are read")

    @property
    def dpi(self) -> tuple[float, float]:
        return INCH / self.pixel[0], INCH / self.pixel[1]

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m]."""
        rows, columns = self.grey.shape
        return columns * self.pixel[0], rows * self.pixel[1]

    def points(self, row_column: Array) -> Array:
        """Image coordinates (N, 2) [m] of rows and columns (N, 2), whole at pixel centres."""
        row, column = row_column.T
        x, y = (column + 0.5) * self.pixel[0], (len(self.grey) - 0.5 - row) * self.pixel[1]
        return np.column_stack([x, y])

    def rows_columns(self, points: Array) -> Array:
        """Rows and columns (N, 2) of points (N, 2) [m], not rounded."""
        x, y = points.T
        row, column = len(self.grey) - 0.5 - y / self.pixel[1], x / self.pixel[0] - 0.5
        return np.column_stack([row, column])

    def at(self, points: Array) -> Array:
        """(N,), grey of the pixels that have the points (N, 2) [m]; NaN outside."""
        row, column = np.rint(self.rows_columns(points)).astype(int).T
        rows, columns = self.grey.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        found = np.full(len(points), np.nan)
        found[inside] = self.grey[row[inside], column[inside]]
        return found

    def gradient(self, points: Array) -> Array:
        """Central differences (N, 2) [1/m] of the grey, along x and y, at the pixels of points."""
        rows, columns = self.grey.shape
        row, column = np.rint(self.rows_columns(points)).astype(int).T
        row, column = np.clip(row, 1, rows - 2), np.clip(column, 1, columns - 2)
        around = [(0, 1), (0, -1), (-1, 0), (1, 0)]
        right, left, above, below = (
            self.grey[row + i, column + j].astype(np.float64) for i, j in around
        )
        return 0.5 * np.column_stack([right - left, above - below]) / np.array(self.pixel)


def read_image(file: Path, dpi: float | None = None, gamma: float | None = None) -> ScanImage:
    """Image of a PNG or TIFF, of its colours the one with the most contrast: the three lines of a
    colour scanner do not see the same place. Its greys are made proportional to light.

    dpi, gamma: in place of the file's own. A file that says neither gamma nor profile is linear.

    Raises ValueError for a file that is no such image, has no resolution, or too many pixels.
    """
    from PIL import Image

    check_file(file, LARGEST_FILE)
    usual, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, PIXELS
    try:
        with reading(file), Image.open(file, formats=("PNG", "TIFF")) as opened:
            columns, rows = opened.size
            if columns * rows > PIXELS:
                raise ValueError(f"it has {columns} x {rows} pixels; at most {PIXELS:g} are read")
            own = opened.info.get("dpi", (0.0, 0.0)) if dpi is None else (dpi, dpi)
            if not all(np.isfinite(float(d)) and float(d) > 1.0 for d in own):
                raise ValueError("it has no resolution; say --dpi")
            if getattr(opened, "n_frames", 1) > 1:
                raise ValueError(f"it has {getattr(opened, 'n_frames', 1)} pages; one is read")
            grey = _grey(opened, gamma)
    finally:
        Image.MAX_IMAGE_PIXELS = usual
    pixel = INCH / float(own[0]), INCH / float(own[1])
    return ScanImage(grey=grey, pixel=pixel, name=file.name)


def _grey(opened: Any, gamma: float | None) -> NDArray[np.uint8]:
    if opened.mode in ("1", "P"):
        raise ValueError("it has few greys or a palette; scan in grey or colour")
    if opened.mode.startswith(("I", "F")):
        deep = np.asarray(opened)
        if deep.dtype.kind == "f" or deep.min() < 0 or deep.max() > 65535:
            raise ValueError(f"pixels of mode {opened.mode} are not read; scan in 8 or 16 bit grey")
        return _light(opened.info, gamma, 65536)[deep]
    if opened.mode in ("L", "LA"):
        return _light(opened.info, gamma, 256)[np.asarray(opened.getchannel("L"))]
    coloured = opened if opened.mode in ("RGB", "RGBA") else opened.convert("RGB")
    small = np.asarray(coloured.reduce(max(1, min(coloured.size) // 500)), dtype=np.float64)
    best = int(np.argmax(small[..., :3].std(axis=(0, 1))))
    return _light(opened.info, gamma, 256)[np.asarray(coloured.getchannel(best))]


def _light(info: dict[str, Any], gamma: float | None, levels: int) -> NDArray[np.uint8]:
    """(levels,), the light of each level of a file, 0 to 255.

    A profile is taken for the curve of sRGB (IEC 61966-2-1).
    """
    level = np.arange(levels) / (levels - 1)
    own = float(info.get("gamma") or 1.0)
    if gamma is not None or not ({"srgb", "icc_profile"} & info.keys()):
        light = level ** (1.0 / own if gamma is None else gamma)
    else:
        light = np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4)
    return np.round(255.0 * light).astype(np.uint8)


class Outline(NamedTuple):
    """A closed edge of the coarse image."""

    points: Array
    """(N, 2) [m], the first repeated as the last."""
    area: float
    """[m^2], above 0."""
    middle: Array
    """(2,) [m], centroid of its area."""


def outlines(image: ScanImage, shortest: float) -> list[Outline]:
    """Closed edges of at least a length [m], at half grey of the image made coarse."""
    from PIL import Image

    n = max(1, int(COARSE / max(image.pixel)))
    coarse = np.asarray(Image.fromarray(image.grey).reduce(n), dtype=np.float32)
    low, high = np.percentile(coarse[::3, ::3], (0.5, 99.5))
    if high - low < CONTRAST:
        raise ValueError(
            f"{image.name}: its greys reach from {low:.0f} to {high:.0f} only: nothing to see"
        )
    found = list[Outline]()
    for line in skimage.measure.find_contours(coarse, skimage.filters.threshold_otsu(coarse)):
        if len(line) < 8 or not np.array_equal(line[0], line[-1]):
            continue
        points = image.points((line + 0.5) * n - 0.5)
        if np.linalg.norm(np.diff(points, axis=0), axis=1).sum() >= shortest:
            area, middle = enclosed(points)
            found.append(Outline(points, abs(area), middle))
    return found


def enclosed(points: Array) -> tuple[float, Array]:
    """Area [m^2], above 0 if counter-clockwise, and centroid (2,) of a closed polygon (N, 2)."""
    origin = points[0]
    (x, y), (u, v) = (points - origin).T, (np.roll(points, -1, axis=0) - origin).T
    cross = x * v - u * y
    area = 0.5 * float(cross.sum())
    if area == 0.0:
        return 0.0, points.mean(axis=0)
    return area, origin + np.array([((x + u) * cross).sum(), ((y + v) * cross).sum()]) / (6 * area)


class Edge(NamedTuple):
    """Edge found near an expected one."""

    points: Array
    """(N, 2) [m], in image coordinates."""
    inside: float
    outside: float
    """Greys of both sides, median along the edge; NaN where nothing was found."""
    spread: float
    """Standard deviation [m] of a normal distribution that the edge was blurred by."""
    white: float
    """Part of the bright side that is 255."""
    beyond: float
    """Part of the expected edge that lies outside of the image, or within its margin."""


def edge_near(image: ScanImage, expected: Array, outwards: Array, *, narrow: float = 0.0) -> Edge:
    """Edge at half grey near an expected one.

    expected, outwards: (N, 2) [m], points in order, and the unit normals that lead out. narrow:
    what lies inside is a kerf or line, whose grey is taken at that depth [m], its middle.
    """
    n = max(1, round(float(np.linalg.norm(np.diff(expected, axis=0), axis=1).sum()) / PIECE))
    near, far = PLATEAU
    margin = far + max(image.pixel)
    (w, h), (x, y) = image.size, expected.T
    beyond = np.mean((x < margin) | (y < margin) | (x > w - margin) | (y > h - margin))
    depths = np.linspace(near, far, 4)
    inner = np.array([image.at(expected - d * outwards) for d in ([narrow] if narrow else depths)])
    outer = np.array([image.at(expected + d * outwards) for d in depths])
    pieces = np.array_split(np.arange(len(expected)), n)
    # Dust on one piece does not shift its half grey: light varies over many.
    insides, outsides = (
        _smooth(np.array([_median(grey[:, of]) for of in pieces])) for grey in (inner, outer)
    )
    tree, found, slopes = KDTree(expected), list[Array](), list[Array]()
    for of, inside, outside in zip(pieces, insides, outsides, strict=True):
        contrast = outside - inside
        if not abs(contrast) >= CONTRAST:
            continue
        points = _crossing(image, expected[of], 0.5 * (inside + outside))
        distance, i = map(np.asarray, tree.query(points))
        # What is nearer to another piece is read with that one.
        own = (distance < WINDOW) & (i >= of[0]) & (i <= of[-1])
        points, i = points[own], i[own]
        gradient = image.gradient(points)
        slope = np.linalg.norm(gradient, axis=1)
        clear = np.einsum("ij,ij->i", gradient, outwards[i]) * np.sign(contrast) > TURNED * slope
        middle = (narrow,) if narrow else BESIDE
        for side, grey, away in ((-1.0, inside, middle), (1.0, outside, BESIDE)):
            beside = [image.at(points + side * d * outwards[i]) for d in away]
            clear &= np.abs(np.mean(beside, axis=0) - grey) < STAINED * abs(contrast)
        found.append(points[clear])
        slopes.append(abs(contrast) / (np.sqrt(2.0 * np.pi) * np.maximum(slope[clear], 1e-9)))
    if not found or not sum(map(len, found)):
        return Edge(np.zeros((0, 2)), np.nan, np.nan, np.nan, np.nan, float(beyond))
    inside, outside = float(np.nanmedian(insides)), float(np.nanmedian(outsides))
    return Edge(
        np.vstack(found),
        inside,
        outside,
        float(np.median(np.concatenate(slopes))),
        float(np.mean((outer if outside > inside else inner) >= 255)),
        float(beyond),
    )


def kerf_near(image: ScanImage, expected: Array, normal: Array) -> tuple[Array, float]:
    """Offset (N,) [m] of the middle of a kerf or line from an expected one (N, 2), and its width
    [m], both roughly."""
    from scipy.ndimage import median_filter, uniform_filter

    t = np.arange(-WINDOW, WINDOW, ACROSS)
    grey = np.array([image.at(expected + d * normal) for d in t]).T
    grey = np.where(np.isfinite(grey), grey, np.nanmedian(grey))
    contrast = np.abs(grey - np.median(grey, axis=1)[:, np.newaxis])
    # The mean over 1 mm of a kerf and over 0.2 mm across it.
    mean = uniform_filter(uniform_filter(contrast, 10, axes=0), 8, axes=1)
    offset = median_filter(t[np.argmax(mean, axis=1)], 21, mode="nearest")
    middle = expected + offset[:, np.newaxis] * normal
    across = np.array([np.nanmean(image.at(middle + d * normal)) for d in t])
    step = np.abs(across - np.median(across))
    return offset, float(ACROSS * np.sum(step > 0.5 * step.max()))


def _smooth(values: Array) -> Array:
    """Running median of the values of pieces, over nine."""
    i = np.arange(len(values))[:, np.newaxis] + np.arange(-4, 5)
    around = values[np.clip(i, 0, len(values) - 1)]
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # all outside
        return np.nanmedian(around, axis=1)


def _median(values: Array) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else np.nan


def _crossing(image: ScanImage, expected: Array, level: float) -> Array:
    """Points (N, 2) [m] at a grey around a piece of edge."""
    around = np.array([expected.min(axis=0) - WINDOW, expected.max(axis=0) + WINDOW])
    corners = image.rows_columns(around)
    top, left = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    bottom, right = np.maximum(np.ceil(corners.max(axis=0)).astype(int) + 1, 0)
    part = image.grey[top:bottom, left:right].astype(np.float32)
    if min(part.shape) < 3:
        return np.zeros((0, 2))
    lines = [line for line in skimage.measure.find_contours(part, level) if len(line) > 4]
    return image.points(np.vstack([np.zeros((0, 2)), *lines]) + np.array([top, left]))
