"""Reading a scan against what was cut: virtual scanners and sheets, drawn anew for each seed.

Judged on seeds from 0 on; every setting of the image chain was chosen on seeds from 100 on and on
the sheet of tests/sim/scan. The bands were written down before the first judged seed was run.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.random import Generator

from armside.arrays import Array
from armside.sim.motion.contour import outward_normal
from armside.sim.part.arcs import MM, Chain, arc, line
from armside.sim.part.curve import ChainCurve
from armside.sim.scan.calibration import calibrated
from armside.sim.scan.reading import BIN, SheetScan, read_scan
from armside.sim.scan.virtual import Process, Scanner, Sheet, drawn_scanner, grid, scanned

from ._engine import Check, Claim, Row, Rows, Tally, at_most

BED = (100 * MM, 100 * MM)
PITCH, CELLS = 5 * MM, (18, 18)
SHORTEST = 4 * MM
"""Wave of 10 Hz at 40 mm/s: errors of shorter waves are not learned from."""
PITCH_SD = 1e-4
"""Standard deviation of the grid's pitch, which nobody knows: 0.5 um on 5 mm. ESTIMATE"""
BEAM_SD = 5e-6
"""Of the beam's width, which the open kerf has to give [m]. ESTIMATE"""
DUST = 15
MEDIAN, WORST = 3.0, 6.0
"""Bands of the deviation below 10 Hz [um RMS], of all contours."""
SIZE, PLACE = 10.0, 10.0
"""Bands of a diameter or width, and of a contour's place on the sheet [um]."""
NOISE = 2.0
"""Factor between stated and actual noise."""


class Cut(NamedTuple):
    """A contour and where the beam was across it."""

    curve: ChainCurve
    s: Array
    d: Array


def sheet(rng: Generator) -> dict[str, Cut]:
    """Circle, square, slot, mark and open kerf of random sizes."""
    radius, half, mark = rng.uniform([5.0, 5.0, 1.2], [13.0, 12.0, 2.5])
    length, width = rng.uniform([20.0, 6.0], [36.0, 12.0])
    x, y, u, v = np.array([-20.0, 17.0, 20.0, 16.0]) + rng.uniform(-1.5, 1.5, 4)
    curves = {
        "circle": arc((x * MM, y * MM), radius * MM, 0.0, 2.0 * np.pi),
        "square": polygon(u + half * np.array([-1, 1, 1, -1]), v + half * np.array([-1, -1, 1, 1])),
        "slot": slot(-12.0, -14.0, length, width),
        "mark": arc((rng.uniform(14, 20) * MM, -8.0 * MM), mark * MM, 0.0, 2.0 * np.pi),
        "kerf": line((10.0 * MM, -22.0 * MM), ((10.0 + rng.uniform(8, 18)) * MM, -22.0 * MM)),
    }
    return {name: cut(ChainCurve(chain), rng) for name, chain in curves.items()}


def polygon(x: Array, y: Array) -> Chain:
    """Closed [mm]."""
    points = MM * np.column_stack([np.append(x, x[0]), np.append(y, y[0])])
    return Chain(points, np.zeros(len(x)))


def slot(x: float, y: float, length: float, width: float) -> Chain:
    """Two lines and two half circles, around a point [mm]."""
    a, r = 0.5 * (length - width), 0.5 * width
    points = np.array([(-a, -r), (a, -r), (a, r), (-a, r), (-a, -r)]) + np.array([x, y])
    return Chain(MM * points, np.array([0.0, 1.0, 0.0, 1.0]))


def cut(curve: ChainCurve, rng: Generator) -> Cut:
    """A tool's error of 20 to 100 um RMS in waves of `SHORTEST` and longer."""
    n = int(curve.length / 10e-6)
    s = (np.arange(n) + 0.5) * curve.length / n
    d = rng.normal(0.0, 10e-6) * np.ones(n)
    waves = np.arange(1, int(curve.length / SHORTEST) + 1)
    size = rng.uniform(20e-6, 100e-6) * rng.standard_normal((2, len(waves))) / np.sqrt(len(waves))
    for k, (a, b) in zip(waves, size.T, strict=True):
        d += a * np.cos(2 * np.pi * k * s / curve.length)
        d += b * np.sin(2 * np.pi * k * s / curve.length)
    return Cut(curve, s, d)


def run(seed: int, tally: Tally) -> Iterator[Row]:
    rng = np.random.default_rng([37, seed])
    scanner, cuts = drawn_scanner(rng), sheet(rng)
    calibration = calibrated([grid_scan(scanner, rng)], PITCH)
    process = Process(error=float(rng.normal(0.0, BEAM_SD)))
    bright, dark = rng.uniform([150.0, 20.0], [235.0, 70.0])
    greys = (bright, dark) if rng.integers(2) else (dark, bright)
    regions = list[tuple[Array, bool]]()
    for i, (name, of) in enumerate(cuts.items()):
        path = of.curve.point(of.s) + of.d[:, None] * outward_normal(of.curve.tangent(of.s))
        when = i / len(cuts)
        one = process.kerf if name == "kerf" else lambda *a, **k: process.edge(a[0], 1, a[1], **k)
        regions.append((one(path, rng, when=when), False))
    spots = [
        (*rng.uniform(0.0, BED), rng.uniform(0.05, 0.4) * MM, rng.uniform(0.0, 250.0))
        for _ in range(DUST)
    ]
    seen = scanned(
        Sheet(regions=regions, material=greys[0], ground=greys[1], spots=spots),
        scanner,
        BED,
        rng,
        place=placed(rng, np.zeros(2), np.pi),
    )
    drawing = {name: of.curve for name, of in cuts.items()}
    row: dict[str, Any] = {"seed": seed}
    for name, of in (("calibrated", calibration), ("not", None)):
        read = read_scan(seen, drawing, calibration=of)
        tally.add(read.notes)
        row |= {f"{key}, {name}": value for key, value in errors(read, cuts).items()}
    yield row


def placed(rng: Generator, middle: Array, turn: float) -> tuple[float, float, float]:
    """Place that brings a point of the drawing near the middle of the bed."""
    angle = rng.uniform(-turn, turn)
    c, s = np.cos(angle), np.sin(angle)
    x, y = 0.5 * np.array(BED) - np.array([[c, -s], [s, c]]) @ middle + rng.uniform(-1, 1, 2) * MM
    return float(x), float(y), float(angle)


def grid_scan(scanner: Scanner, rng: Generator) -> Any:
    pitch = PITCH * (1.0 + PITCH_SD * rng.standard_normal())
    angle = np.radians(rng.uniform(4.5, 7.0))
    c, s = np.cos(angle), np.sin(angle)
    middle = 0.5 * pitch * np.array(CELLS)
    x, y = 0.5 * np.array(BED) - np.array([[c, -s], [s, c]]) @ middle
    return scanned(grid(pitch, CELLS), scanner, BED, rng, place=(float(x), float(y), angle))


def errors(read: SheetScan, cuts: dict[str, Cut]) -> dict[str, Any]:
    """[um]. The sheet is placed by what was cut, so one motion of all contours is taken off. What
    is left of each is its size (the mean), its place on the sheet, and the rest, across."""
    off, J = list[Array](), list[Array]()
    for name, of in read.contours.items():
        p, t = cuts[name].curve.point(of.arc_length), cuts[name].curve.tangent(of.arc_length)
        J.append(np.column_stack([t[:, 1], -t[:, 0], -np.einsum("ij,ij->i", p, t)]))
        off.append(of.deviation - np.interp(of.arc_length, cuts[name].s, cuts[name].d))
    motion = np.linalg.lstsq(np.vstack(J), np.concatenate(off), rcond=None)[0]
    across, size, place, actual, stated = ([] for _ in range(5))
    for (name, of), e, A in zip(read.contours.items(), off, J, strict=True):
        left = e - A @ motion
        own = np.linalg.lstsq(A, left - left.mean(), rcond=1e-6)[0]
        rest = left - left.mean() - A @ own
        across.append(1e6 * np.std(below(rest, of.arc_length, cuts[name].curve)))
        actual.append(np.std(left))
        stated.append(of.noise)
        if name != "kerf":
            size.append(2e6 * left.mean())
            translated = np.linalg.lstsq(A[:, :2], left - left.mean(), rcond=None)[0]
            place.append(1e6 * np.hypot(*translated))
    return {
        "across": float(np.median(across)),
        "across, worst": float(np.max(across)),
        "size": float(np.abs(size).max()),
        "place": float(np.max(place)),
        "noise": float(np.sqrt(np.mean(np.square(stated)) / np.mean(np.square(actual)))),
        "_across": np.array(across),
    }


def below(left: Array, s: Array, curve: ChainCurve) -> Array:
    """An error without waves shorter than `SHORTEST`; gaps are bridged."""
    n = max(8, round(curve.length / BIN))
    every = (np.arange(n) + 0.5) * curve.length / n
    closed = bool(curve.chain.closed)
    filled = np.interp(every, s, left, period=curve.length if closed else None)
    both = filled if closed else np.concatenate([filled, filled[::-1]])
    spectrum = np.fft.rfft(both)
    spectrum[np.fft.rfftfreq(len(both), curve.length / n) > 1.0 / SHORTEST] = 0.0
    return np.fft.irfft(spectrum, len(both))[:n]


def checks(rows: Rows) -> Iterator[Check]:
    known, unknown = rows.joined("_across, calibrated"), rows.joined("_across, not")
    yield at_most(
        "deviation across below 10 Hz, all contours, median [um]",
        float(np.median(known)),
        MEDIAN,
        ".2f",
    )
    yield at_most("the same, worst", float(known.max()), WORST, ".2f", "worst ")
    yield at_most(
        "a diameter or width [um]", float(rows["size, calibrated"].max()), SIZE, ".1f", "worst "
    )
    yield at_most(
        "place of a contour on the sheet [um]",
        float(rows["place, calibrated"].max()),
        PLACE,
        ".1f",
        "worst ",
    )
    ratio = rows["noise, calibrated"]
    yield at_most(
        "stated over actual noise, or its inverse",
        float(np.maximum(ratio, 1.0 / ratio).max()),
        NOISE,
        ".2f",
        "worst ",
    )
    yield at_most(
        "calibrated over uncalibrated, median of all contours",
        float(np.median(known) / np.median(unknown)),
        1.0,
        ".2f",
    )


CLAIM = Claim(
    title="A scan against what was cut [um]: {n} scanners and sheets",
    seeds=20,
    run=run,
    checks=checks,
)
