"""Virtual flatbed scanner and cut edges, for tests and virtual users.

No real scan was seen: each number has its source or is an ESTIMATE.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armside.arrays import Array

from .image import INCH, ScanImage, enclosed

SPREAD = 12e-6
"""Standard deviation of the point spread of optics and sensor [m]. ESTIMATE"""
GREY_NOISE = 2.0
"""Standard deviation of a pixel, of 255. ESTIMATE"""
FINE = 4
"""Rows and columns of cells in a pixel, each as full as it is: an edge is drawn without a bias."""
MARGIN = 4
"""Pixels around a tile that its blur sees."""
TILE = 96
"""Pixels along a tile; only those with an edge are drawn."""
PERIODS = (5e-3, 20e-3)
"""Of the carriage's wobble [m]: teeth of belts and gears. ESTIMATE"""
SIDEWAYS = 0.3
"""Part of the wobble across the carriage's way. ESTIMATE"""


@dataclass(frozen=True, kw_only=True)
class Scanner:
    """Errors of one scanner. The default is an ideal one, but for its optics."""

    dpi: float = 1200.0
    spread: float = SPREAD
    noise: float = GREY_NOISE
    scale: tuple[float, float] = (0.0, 0.0)
    """In x and y: sd 1e-3 (ESTIMATE); 6e-3 between halves of a sheet was found on an Epson V200
    (discuss.pixls.us 29481)."""
    skew: float = 0.0
    """[rad], of y against x; sd 5e-4 (ESTIMATE)."""
    wobble: tuple[tuple[float, float, float], ...] = ()
    """Amplitude, period [m] and phase [rad] of sines along y; 10 to 30 um in sum (ESTIMATE)."""
    irregular: float = 0.0
    """Wobble that does not repeat, RMS [m]; 2e-6 (ESTIMATE)."""
    folds: tuple[tuple[float, float], ...] = ()
    """Place x [m] and step [m] of the joints of a contact image sensor (CIS)."""

    def seen(self, points: Array, size: tuple[float, float], rng: Generator) -> Array:
        """Points (N, 2) [m] on the glass, where the image has them."""
        middle = 0.5 * np.array(size)
        x, y = (points - middle).T
        moved = np.column_stack([(1 + self.scale[0]) * x + self.skew * y, (1 + self.scale[1]) * y])
        for amplitude, period, phase in self.wobble:
            w = amplitude * np.sin(2 * np.pi * points[:, 1] / period + phase)
            moved += np.column_stack([SIDEWAYS * w, w])
        if self.irregular:
            n = int(np.ceil(size[1] / PERIODS[0])) + 2
            w = self.irregular * rng.standard_normal(n)
            moved[:, 1] += np.interp(points[:, 1], np.arange(n) * PERIODS[0], w)
        for at, step in self.folds:
            moved[:, 0] += step * (points[:, 0] > at)
        return middle + moved


def drawn_scanner(rng: Generator, *, dpi: float = 1200.0) -> Scanner:
    """A scanner of the kind one buys, by the estimates above."""
    peak = rng.uniform(10e-6, 30e-6)
    parts = rng.dirichlet(np.ones(3))
    wobble = tuple(
        (float(peak * part), float(rng.uniform(*PERIODS)), float(rng.uniform(0.0, 2 * np.pi)))
        for part in parts
    )
    sx, sy = 1e-3 * rng.standard_normal(2)
    return Scanner(
        dpi=dpi,
        scale=(float(sx), float(sy)),
        skew=float(5e-4 * rng.standard_normal()),
        wobble=wobble,
        irregular=2e-6,
    )


@dataclass(frozen=True, kw_only=True)
class Process:
    """Edges that a beam leaves along its path."""

    beam: float = 0.2e-3
    """Width of the kerf [m]."""
    error: float = 0.0
    """Of the width [m], by material, focus and gas: unknown to the user; sd 5e-6 (ESTIMATE)."""
    direction: float = 0.0
    """Difference of the width [m] between motion along `axis` and across: polarisation. ESTIMATE"""
    axis: float = 0.0
    """[rad]."""
    sense: float = 0.0
    """Sideways shift of both edges [m], to the right of the motion: a beam that is not round."""
    drift: float = 0.0
    """Growth of the width [m] from the first contour to the last, by heat. ESTIMATE"""
    speed: float = 0.0
    """Growth of the width [m] where the beam moves at half the nominal speed. ESTIMATE"""
    wave: float = 3e-6
    """RMS [m] of an edge, correlated over 3 mm. ESTIMATE"""
    roughness: float = 4e-6
    """RMS [m] of an edge, correlated over 0.1 mm. ESTIMATE"""

    def offset(
        self, heading: Array, side: int, *, when: float = 0.0, speed: Array | float = 1.0
    ) -> Array:
        """(N,) [m], from the beam's middle to the edge on the right (side 1) or left (-1), positive
        to the right.

        heading: (N,) [rad]. when: 0 for the first contour of the sheet, 1 for the last. speed: over
        the nominal one.
        """
        width = self.beam + self.error + self.drift * when
        width = width + 0.5 * self.direction * np.cos(2.0 * (heading - self.axis))
        width = width - self.speed * np.log2(speed)
        return 0.5 * side * width + self.sense

    def edge(
        self,
        path: Array,
        side: int,
        rng: Generator,
        *,
        when: float = 0.0,
        speed: Array | float = 1.0,
    ) -> Array:
        """Points (N, 2) of the edge on one side of a closed path (N, 2) [m] of the beam's middle,
        of which the last is followed by the first."""
        tangent = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
        return self._moved(path, tangent, side, rng, when, speed)

    def kerf(
        self,
        path: Array,
        rng: Generator,
        *,
        when: float = 0.0,
        speed: Array | float = 1.0,
    ) -> Array:
        """Points of the closed edge around an open path (N, 2) [m], with round ends."""
        tangent = np.gradient(path, axis=0)
        right, left = (self._moved(path, tangent, i, rng, when, speed) for i in (1, -1))
        return np.vstack([right, _cap(right[-1], left[-1]), left[::-1], _cap(left[0], right[0])])

    def _moved(
        self,
        path: Array,
        tangent: Array,
        side: int,
        rng: Generator,
        when: float,
        speed: Array | float,
    ) -> Array:
        heading = np.arctan2(tangent[:, 1], tangent[:, 0])
        normal = np.column_stack([np.sin(heading), -np.cos(heading)])
        step = float(np.median(np.linalg.norm(np.diff(path, axis=0), axis=1)))
        out = self.offset(heading, side, when=when, speed=speed)
        for rms, length in ((self.wave, 3e-3), (self.roughness, 0.1e-3)):
            out = out + rms * _correlated(len(path), length / step, rng)
        return path + out[:, np.newaxis] * normal


def _correlated(n: int, length: float, rng: Generator) -> Array:
    """(n,) periodic normal numbers of RMS 1, correlated over a number of samples."""
    gain = np.exp(-((np.pi * length * np.fft.rfftfreq(n)) ** 2) / 2.0)
    gain[0] = 0.0  # a constant is the width's
    found = np.fft.irfft(gain * np.fft.rfft(rng.standard_normal(n)), n)
    return found / max(float(found.std()), 1e-12) if n > 4.0 * length else np.zeros(n)


def _cap(first: Array, last: Array) -> Array:
    """Half circle (15, 2) counter-clockwise from one point to another, without both."""
    middle, arm = 0.5 * (first + last), 0.5 * (first - last)
    angle = np.linspace(0.0, np.pi, 17)[1:-1, np.newaxis]
    return middle + np.cos(angle) * arm + np.sin(angle) * np.array([-arm[1], arm[0]])


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """What lies on the glass: regions of material and ground, one upon the other."""

    regions: Sequence[tuple[Array, bool]]
    """Closed polygons (N, 2) [m] with points less than a pixel apart; whether material lies inside.
    Later ones are drawn over earlier ones."""
    everywhere: bool = True
    """Whether material lies around all of them: a sheet larger than the bed."""
    material: float = 190.0
    ground: float = 40.0
    """Greys, of 255."""
    spots: Sequence[tuple[float, float, float, float]] = field(default=())
    """Dust: place x, y, radius [m] in the image, and grey."""


def grid(pitch: float, cells: tuple[int, int], width: float = 0.1e-3) -> Sheet:
    """Glass with dark lines `pitch` [m] apart around a number of cells in x and y, from (0, 0)."""
    n = 200  # points along a side: straight ones, that a scanner bends
    side = np.linspace(0.5 * width, pitch - 0.5 * width, n)
    low, high = np.full(n, side[0]), np.full(n, side[-1])
    cell = np.vstack(
        [
            np.column_stack(xy)
            for xy in ((side, low), (high, side), (side[::-1], high), (low, side[::-1]))
        ]
    )
    at = pitch * np.array([(i, j) for i in range(cells[0]) for j in range(cells[1])])
    # Around the lines lies glass again: a frame of dark lines on bright ground.
    rim = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * pitch * cells + 0.5 * width * np.array(
        [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    )
    return Sheet(regions=[(rim, False), *((cell + p, True) for p in at)], material=210.0)


def scanned(
    sheet: Sheet,
    scanner: Scanner,
    size: tuple[float, float],
    rng: Generator,
    *,
    place: tuple[float, float, float] = (0.0, 0.0, 0.0),
    mirrored: bool = False,
    name: str = "virtual",
) -> ScanImage:
    """Image of an area [m] of the glass, 8 bit.

    place: x, y [m] and angle [rad] of the sheet's coordinates on the glass.
    """
    from PIL import Image, ImageDraw
    from scipy.ndimage import gaussian_filter

    pixel = INCH / scanner.dpi
    columns, rows = (round(length / pixel) for length in size)
    x, y, angle = place
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]]) @ np.diag([-1.0 if mirrored else 1.0, 1.0])
    seen = list[Array]()
    for points, _ in sheet.regions:
        at = scanner.seen(points @ turn.T + np.array([x, y]), size, rng) / pixel
        seen.append(np.column_stack([at[:, 0], rows - at[:, 1]]))  # columns and rows
    cover = Image.new("L", (columns, rows), sheet.everywhere)
    for (_, material), polygon in zip(sheet.regions, seen, strict=True):
        ImageDraw.Draw(cover).polygon(polygon.ravel().tolist(), fill=int(material))
    crossings = [_crossings(polygon) for polygon in seen]
    boxes = [(polygon.min(axis=0), polygon.max(axis=0)) for polygon in seen]
    wide = TILE + 2 * MARGIN

    def tile(i: int, j: int) -> NDArray[np.float32]:
        """Part of each pixel of a tile that is material, exactly, as the optics see it."""
        top, left = i * TILE - MARGIN, j * TILE - MARGIN
        cells = np.full((wide * FINE, wide * FINE), float(sheet.everywhere), dtype=np.float32)
        for (_, material), crossing, (low, high) in zip(
            sheet.regions, crossings, boxes, strict=True
        ):
            if (low < (left + wide, top + wide)).all() and (high > (left, top)).all():
                inside = _inside(crossing, top * FINE, left * FINE, wide * FINE)
                cells += inside * (material - cells)
        blurred = gaussian_filter(cells, scanner.spread / pixel * FINE)
        mean = blurred.reshape(wide, FINE, wide, FINE).mean(axis=(1, 3))
        return mean[MARGIN:-MARGIN, MARGIN:-MARGIN]

    corners = [(a, b) for a in (-MARGIN, MARGIN) for b in (-MARGIN, MARGIN)]
    near = np.vstack([polygon[:, ::-1] + at for polygon in seen for at in corners])
    touched = np.unique(near // TILE, axis=0).astype(int)
    image = np.empty((rows, columns), dtype=np.uint8)
    for i in range(-(-rows // TILE)):  # band by band: a whole bed takes gigabytes in floats
        band = np.array(cover.crop((0, i * TILE, columns, (i + 1) * TILE)), dtype=np.float32)
        for j in touched[touched[:, 0] == i, 1]:
            if 0 <= j * TILE < columns:
                to = band[:, j * TILE : (j + 1) * TILE]
                to[:] = tile(i, j)[:, : to.shape[1]]
        grey = sheet.ground + (sheet.material - sheet.ground) * band
        for dust_x, dust_y, radius, value in sheet.spots:
            at = dust_x / pixel, rows - dust_y / pixel - i * TILE
            _spot(grey, at, radius / pixel, value)
        grey += scanner.noise * rng.standard_normal(grey.shape, dtype=np.float32)
        to = image[i * TILE : (i + 1) * TILE]
        to[:] = np.clip(np.rint(grey), 0, 255)[: len(to)]
    return ScanImage(grey=image, pixel=(pixel, pixel), name=name)


def _crossings(polygon: Array) -> Array:
    """Row of cells, x [cells] and sign of each crossing (N, 3) of a closed polygon (N, 2) [pixels]
    with a row's middle, by row; the signs add to 1 where the polygon is to the left."""
    p = polygon if enclosed(polygon)[0] > 0.0 else polygon[::-1]
    (x, y), (u, v) = p.T * FINE, np.roll(p, -1, axis=0).T * FINE
    first, last = np.ceil(y - 0.5).astype(int), np.ceil(v - 0.5).astype(int)
    n = np.abs(last - first)
    which = np.repeat(np.arange(len(p)), n)
    before = np.repeat(np.concatenate([[0], np.cumsum(n)[:-1]]), n)
    row = np.minimum(first, last)[which] + np.arange(len(which)) - before
    at = x[which] + (u - x)[which] * (row + 0.5 - y[which]) / (v - y)[which]
    found = np.column_stack([row, at, np.sign(first - last)[which]])
    return found[np.argsort(row, kind="stable")]


def _inside(crossings: Array, top: int, left: int, n: int) -> NDArray[np.float32]:
    """Part of each of (n, n) cells inside a polygon."""
    first, last = np.searchsorted(crossings[:, 0], (top, top + n))
    row, x, sign = crossings[first:last].T
    row, x = (row - top).astype(int), np.clip(x - left, 0.0, n)
    column = x.astype(int)
    change = np.zeros((n, n + 2), dtype=np.float32)
    np.add.at(change, (row, column), sign * (1.0 - (x - column)))
    np.add.at(change, (row, column + 1), sign * (x - column))
    return np.cumsum(change, axis=1)[:, :n]


def _spot(grey: NDArray[np.float32], at: tuple[float, float], radius: float, value: float) -> None:
    """Paint a disc at a column and row, which may lie outside."""
    (column, row), r = at, int(np.ceil(radius)) + 1
    top, left = max(int(row) - r, 0), max(int(column) - r, 0)
    part = grey[top : max(int(row) + r + 1, 0), left : int(column) + r + 1]
    y, x = np.mgrid[top : top + part.shape[0], left : left + part.shape[1]]
    part[np.hypot(x + 0.5 - column, y + 0.5 - row) < radius] = value
