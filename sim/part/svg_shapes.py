"""Chains of the segments of an SVG path."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import svgelements

from armside.arrays import Array

from .biarc import fitted
from .chain import Chain, arc, joined, line

ROUND = 1e-9
"""Relative difference of half axes and of their angle from 90 deg in a circle."""


def chains(path: Any, scale: float) -> Iterator[Chain]:
    """A chain [m] for each part of a path; `scale` in metres per pixel."""
    pieces: list[Chain] = []
    for segment in path:
        if isinstance(segment, svgelements.Move):
            if pieces:
                yield _whole(pieces)
            pieces = []
            continue
        chain = _chain(segment, scale)
        if chain is not None:
            pieces.append(_from_end(pieces, chain))
        if isinstance(segment, svgelements.Close):
            if pieces:
                yield _whole(pieces)
            pieces = []
    if pieces:
        yield _whole(pieces)


def _chain(segment: Any, scale: float) -> Chain | None:
    """One segment; None for one of zero length, as drawing programs leave them."""
    start, end = _point(segment.start, scale), _point(segment.end, scale)
    if isinstance(segment, (svgelements.Line, svgelements.Close)):
        return None if np.array_equal(start, end) else line(start, end)
    if isinstance(segment, svgelements.Arc):
        return _arc(segment, scale)
    if isinstance(segment, svgelements.QuadraticBezier):
        control = _point(segment.control, scale)
        return _bezier(np.array([start, control, end]))
    if isinstance(segment, svgelements.CubicBezier):
        controls = [_point(segment.control1, scale), _point(segment.control2, scale)]
        return _bezier(np.array([start, *controls, end]))
    raise ValueError(f"{type(segment).__name__} is not known here")


def _bezier(control: Array) -> Chain | None:
    if not np.ptp(control, axis=0).any():
        return None
    n = len(control) - 1
    first, step = np.poly1d([1.0, 0.0]), np.poly1d([-1.0, 1.0])
    basis = [_binomial(n, k) * first**k * step ** (n - k) for k in range(n + 1)]
    slopes = [polynomial.deriv() for polynomial in basis]

    def at(t: float) -> tuple[Array, Array]:
        return (
            np.array([b(t) for b in basis]) @ control,
            np.array([b(t) for b in slopes]) @ control,
        )

    return fitted(at, [0.0, 1.0])


def _binomial(n: int, k: int) -> float:
    return float(np.prod([(n - i) / (i + 1) for i in range(k)]))


def _arc(segment: Any, scale: float) -> Chain | None:
    centre = _point(segment.center, scale)
    first = _point(segment.prx, scale) - centre
    second = _point(segment.pry, scale) - centre
    begin, sweep = float(segment.get_start_t()), float(segment.sweep)
    a, b = np.linalg.norm(first), np.linalg.norm(second)
    if sweep == 0.0 or a * b == 0.0:
        return None
    if abs(a - b) < ROUND * a and abs(first @ second) < ROUND * a * b:
        turn = np.sign(first[0] * second[1] - first[1] * second[0])
        angle = np.arctan2(first[1], first[0]) + turn * begin
        return arc(centre, float(a), float(angle), float(turn * sweep))

    def at(t: float) -> tuple[Array, Array]:
        direction = np.sign(sweep) * (np.cos(t) * second - np.sin(t) * first)
        return centre + np.cos(t) * first + np.sin(t) * second, direction

    parts = max(1, int(np.ceil(abs(sweep) / (np.pi / 2))))
    return fitted(at, (begin + sweep * np.linspace(0.0, 1.0, parts + 1)))


def _from_end(pieces: list[Chain], chain: Chain) -> Chain:
    """The chain from the exact end of the one before."""
    if not pieces:
        return chain
    return Chain(np.vstack([pieces[-1].points[-1:], chain.points[1:]]), chain.bulge)


def _whole(pieces: list[Chain]) -> Chain:
    """Pieces in one; its end is exactly its start where they differ by rounding."""
    whole = joined(pieces)
    first, last = whole.points[0], whole.points[-1]
    if 0.0 < np.linalg.norm(last - first) < 1e-9 * max(1.0, float(np.abs(whole.points).max())):
        return Chain(np.vstack([whole.points[:-1], first[np.newaxis]]), whole.bulge)
    return whole


def _point(point: Any, scale: float) -> Array:
    return scale * np.array([float(point.x), -float(point.y)])
