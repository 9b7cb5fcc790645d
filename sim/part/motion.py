"""Motion of the tool over a whole part: rapid moves and cuts, one after the other, in time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array
from armside.ilc.workbench.task import along_path

from ..motion.contour import ClosedCurve
from ..motion.path import Plane
from ..motion.timing import Timing
from ..motion.tool_motion import LimitHit, ToolMotion
from .arcs import Chain
from .curve import Kind, centred

SAME = 1e-9
"""[m], rounding of two plans of the same path."""


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
        s = np.array([self.lead, self.path.length - self.lead])
        low, high = np.zeros_like(s), np.full_like(s, self.timing.duration)
        for _ in range(60):  # of bisection
            middle = 0.5 * (low + high)
            before = self.timing.at(middle)[0] < s
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        first, last = (self.start + high).tolist()
        return first, last


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
        return tuple(self._places())

    def _places(self) -> Iterator[ContourPlace]:
        for cut in self.cuts:
            curve, middle = centred(cut.turn)
            plane = Plane(self.to_base(middle), self.plane.axes)
            span, closed = cut.contour_time, cut.turn.closed
            yield ContourPlace(plane=plane, curve=curve, contour_time=span, closed=closed)


def on_grid(time: float, step: float) -> float:
    """The first multiple of `step` [s] that is not before `time`."""
    return float(np.ceil(time / step - 1e-9)) * step


def samples_until(legs: Sequence[Leg], rest_after: float, step: float) -> int:
    """Samples from 0 to the rest after the last leg."""
    return int(np.ceil((legs[-1].end + rest_after) / step - 1e-9)) + 1


Motion = ToolMotion | PartMotion


def carried(correction: Array, before: Motion, motion: Motion, *, anywhere: bool = False) -> Array:
    """The correction (N, n) that was learned along `before`, for `motion`: (M, n).

    The same samples where both are timed alike, otherwise by the place on the path.
    anywhere: the path may lie elsewhere, as that of another robot does.

    Raises ValueError where they follow different paths.
    """
    if not follows(before, motion, anywhere=anywhere):
        which = "contour" if anywhere else "tool path"
        raise ValueError(f"its {which} is another one, and a correction belongs to its path")
    if len(correction) == len(motion.time) and np.array_equal(before.position, motion.position):
        return correction
    # Leads that are longer at a higher speed go on along the contour.
    return along_path(correction, before.arc_length, motion.arc_length)


def follows(before: Motion, motion: Motion, *, anywhere: bool = False) -> bool:
    """Whether two motions follow the same path with the same orientation of the tool.

    anywhere: the same contours, wherever they lie.
    """

    def of(m: Motion) -> list[Array]:
        return [*m.outline, *([] if anywhere else [m.plane.origin, m.plane.axes])]

    pairs = list(zip(of(before), of(motion), strict=False))
    same = len(before.outline) == len(motion.outline) and all(
        a.shape == b.shape and np.allclose(a, b, rtol=0, atol=SAME) for a, b in pairs
    )
    return same and (anywhere or bool(np.allclose(before.quaternion[0], motion.quaternion[0])))
