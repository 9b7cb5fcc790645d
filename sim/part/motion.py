"""Motion of the tool over a whole part: rapid moves and cuts, one after the other, in time."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ..motion.contour import ClosedCurve
from ..motion.path import Plane
from ..motion.timing import Timing
from ..motion.tool_motion import LimitHit
from .arcs import Chain
from .curve import Kind, centred


@dataclass(frozen=True, kw_only=True)
class Leg:
    """Motion along a chain, from rest to rest."""

    path: Chain = field(repr=False)
    """In the coordinates of the drawing."""
    timing: Timing = field(repr=False)
    start: float
    """Time at which it begins [s]."""

    @property
    def end(self) -> float:
        """[s]."""
        return self.start + self.timing.duration

    def point(self, time: ArrayLike) -> Array:
        """(..., 2) [m], in the drawing; its ends before and after it."""
        s, _, _ = self.timing.at(np.asarray(time, dtype=np.float64) - self.start)
        return self.path.point(np.clip(s, 0.0, self.path.length))


@dataclass(frozen=True, kw_only=True)
class CutLeg(Leg):
    """Cut of one contour, with its leads."""

    name: str
    kind: Kind
    lead: float
    """Length of each lead [m]."""
    asked_speed: float
    """[m/s]."""

    @property
    def reached_speed(self) -> float:
        """Highest speed [m/s]."""
        return self.timing.top_speed

    @cached_property
    def turn(self) -> Chain:
        """The path without its leads."""
        if self.lead == 0.0:
            return self.path
        return Chain(self.path.points[1:-1], self.path.bulge[1:-1])

    @cached_property
    def contour_time(self) -> tuple[float, float]:
        """Start and end of the contour [s], without leads."""
        ends = np.array([self.lead, self.path.length - self.lead])
        first, last = self.start + _time_at(self.timing, ends)
        return float(first), float(last)


@dataclass(frozen=True, kw_only=True)
class ContourPlace:
    """One contour of a part as tool error and path accuracy take it: around its own middle."""

    plane: Plane
    curve: ClosedCurve
    contour_time: tuple[float, float]
    """[s]."""
    closed: bool

    def is_on_contour(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Mask of the times [s] on the contour, without leads."""
        first, last = self.contour_time
        t = np.asarray(time, dtype=np.float64)
        return (t >= first) & (t < last)


@dataclass(frozen=True, kw_only=True)
class PartMotion:
    """Tool path of a part in time, at rest at both ends; its middle lies at the plane's origin."""

    legs: tuple[Leg, ...] = field(repr=False)
    """In the order of time; cuts are `CutLeg`."""
    plane: Plane
    middle: tuple[float, float]
    """Of the part in the drawing [m]."""
    tool_quaternion: tuple[float, float, float, float]
    """Base to tool."""
    n_samples: int
    step: float = 0.004
    """[s]."""
    rest_before: float = 0.28
    """[s]."""
    limits_hit: tuple[LimitHit, ...] = ()

    @property
    def cuts(self) -> tuple[CutLeg, ...]:
        """In their order."""
        return tuple(leg for leg in self.legs if isinstance(leg, CutLeg))

    @property
    def outline(self) -> tuple[Array, ...]:
        """Corners of each leg in the drawing [m], by which paths are told apart."""
        return tuple(leg.path.points for leg in self.legs)

    @cached_property
    def time(self) -> Array:
        """(N,) [s], from 0."""
        return np.arange(self.n_samples, dtype=np.float64) * self.step

    @property
    def position(self) -> Array:
        """(N, 3) [m], base axes."""
        return self._position

    @cached_property
    def _position(self) -> Array:
        return self.position_at(self.time)

    @property
    def quaternion(self) -> Array:
        """(N, 4), base to tool."""
        return np.tile(self.tool_quaternion, (self.n_samples, 1))

    @cached_property
    def arc_length(self) -> Array:
        """(N,) [m], of all moves and cuts together."""
        travelled = np.zeros(self.n_samples)
        for leg in self.legs:
            s, _, _ = leg.timing.at(np.clip(self.time - leg.start, 0.0, leg.timing.duration))
            travelled += np.clip(s, 0.0, leg.path.length)
        return np.maximum.accumulate(travelled)

    @property
    def motion_end(self) -> float:
        """[s]."""
        return self.legs[-1].end

    def position_at(self, time: ArrayLike) -> Array:
        """Programmed tool position (..., 3) [m] at any times [s], base axes."""
        time = np.asarray(time, dtype=np.float64)
        begins = np.array([leg.start for leg in self.legs])
        current = np.clip(np.searchsorted(begins, time, side="right") - 1, 0, None)
        points = np.empty((*time.shape, 2))
        for i, leg in enumerate(self.legs):
            own = current == i
            points[own] = leg.point(time[own])
        return self.to_base(points)

    def to_base(self, p: Array) -> Array:
        """Points (..., 3) [m] in base axes of points (..., 2) of the drawing."""
        return self.plane.to_base(p - np.array(self.middle))

    def is_on_contour(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Mask of the times [s] on any contour, without leads."""
        edges = np.array([cut.contour_time for cut in self.cuts]).ravel()
        inside = np.searchsorted(edges, np.asarray(time, dtype=np.float64), side="right")
        return np.asarray(inside % 2 == 1)

    @cached_property
    def places(self) -> tuple[ContourPlace, ...]:
        """Contours of the cuts, in their order."""
        return tuple(self._place(cut) for cut in self.cuts)

    def _place(self, cut: CutLeg) -> ContourPlace:
        curve, middle = centred(cut.turn)
        plane = Plane(self.to_base(middle), self.plane.axes)
        span, closed = cut.contour_time, cut.turn.closed
        return ContourPlace(plane=plane, curve=curve, contour_time=span, closed=closed)


def _time_at(timing: Timing, s: Array) -> Array:
    """Times [s] from the start of a timing at which it is at arc lengths s [m]: bisection."""
    low, high = np.zeros_like(s), np.full_like(s, timing.duration)
    for _ in range(60):
        middle = 0.5 * (low + high)
        before = timing.at(middle)[0] < s
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return high


def on_grid(time: float, step: float) -> float:
    """The first multiple of `step` [s] that is not before `time`."""
    return float(np.ceil(time / step - 1e-9)) * step


def samples_until(legs: Sequence[Leg], rest_after: float, step: float) -> int:
    """Samples from 0 to the rest after the last leg."""
    return int(np.ceil((legs[-1].end + rest_after) / step - 1e-9)) + 1
