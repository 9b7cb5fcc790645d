"""Placement of a drawing in an image of the sheet, as one: first coarse, whatever its angle."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.ndimage import median_filter
from scipy.spatial import KDTree

from armside.arrays import Array

from ..motion.contour import ClosedCurve, outward_normal
from .image import Outline, enclosed

STEP = 1e-3
"""Distance of the points that stand for a contour in the search [m]."""
SIMILAR = 0.12
"""Relative difference of area within which an outline may be a contour."""
WIDER = 0.15e-3
"""Or the offset of its edge, as by a wider beam [m]."""
STRETCHED = 0.012
"""Relative difference of distances, twice the 0.6 % that a cheap scanner was found off by."""
LOOSE = 1.0e-3
"""Difference of distances beside that [m]."""
FOUND = 1.0e-3
"""Largest error that a fit may leave on any contour [m]."""
TRIMMED = 0.8
"""Part of a contour's points that its error is of: the others may be torn."""
RIVAL = (2.0, 0.1e-3)
"""A second placement is as good if its error is below that many times the first's and [m]."""
ASIDE = np.radians(3.0)
"""Angle from which on a placement is another."""
APART = 10e-3
"""Distance of two contours that gives an angle [m]."""
MOST = 300
"""Most placements that are tried."""
FARTHEST = 2.0e-3
"""Distance of an edge from where it is drawn up to which it is followed [m]."""
MEDIAN = 41
"""Points whose median follows an edge, 0.1 mm apart."""


class Seen(Enum):
    """What a contour leaves in the image."""

    HOLE = 1
    """A hole in the sheet: its edge is half a beam outside of the contour."""
    PIECE = -1
    """A piece: its edge is half a beam inside."""
    KERF = 0
    """An open cut of which both edges are seen."""


@dataclass(frozen=True, eq=False)
class DrawnContour:
    """A contour in the coordinates of the drawing [m], and what of it is seen."""

    name: str
    curve: ClosedCurve
    seen: Seen

    def edge(self, spacing: float, offset: float) -> tuple[Array, Array]:
        """Points (N, 2) [m] moved out by an offset, and outward normals (N, 2)."""
        n = max(48, int(np.ceil(self.curve.length / spacing)))
        s = (np.arange(n) + 0.5) * self.curve.length / n
        normal = outward_normal(self.curve.tangent(s))
        return self.curve.point(s) + offset * normal, normal

    @cached_property
    def coarse(self) -> tuple[Array, Array]:
        """Points and normals of its edge, for the search; the beam counts little there."""
        return self.edge(STEP, 0.1e-3 * self.seen.value)

    @cached_property
    def area_and_middle(self) -> tuple[float, Array]:
        """Enclosed area [m^2] and its centroid (2,) [m]."""
        area, middle = enclosed(self.coarse[0])
        return abs(area), middle


@dataclass(frozen=True)
class Pose:
    """Drawing in the image: p_image = R(angle) p + (x, y), with x of p negated if mirrored."""

    x: float
    y: float
    """[m]."""
    angle: float
    """[rad]."""
    mirrored: bool = False

    @cached_property
    def matrix(self) -> Array:
        """(2, 2)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, -s], [s, c]]) @ np.diag([-1.0 if self.mirrored else 1.0, 1.0])

    def to_image(self, points: Array) -> Array:
        """(N, 2) [m], of the drawing -> of the image."""
        return points @ self.matrix.T + np.array([self.x, self.y])

    def to_drawing(self, points: Array) -> Array:
        """(N, 2) [m], of the image -> of the drawing."""
        return (points - np.array([self.x, self.y])) @ self.matrix

    def moved(self, step: Array) -> "Pose":
        """After a small motion of the image's points: x, y [m], and angle [rad] about (x, y)."""
        x, y, angle = (float(value) for value in step)
        return Pose(self.x + x, self.y + y, self.angle + angle, self.mirrored)


def located(drawn: Sequence[DrawnContour], found: Sequence[Outline], wider: float = WIDER) -> Pose:
    """Placement of all closed contours on the outlines of an image. wider: as `WIDER` [m].

    Raises ValueError if a contour is not found, or if two placements are as good.
    """
    closed = [contour for contour in drawn if contour.seen is not Seen.KERF]
    if not closed:
        raise ValueError("the drawing has no closed contour, by which a sheet is placed")
    like = [_like(contour, found, wider) for contour in closed]
    for contour, of in zip(closed, like, strict=True):
        if not of:
            raise ValueError(f"nothing in it is as large as {contour.name}: cropped, or another")
    alike = list({id(outline): outline for of in like for outline in of}.values())
    cloud = KDTree(np.vstack([outline.points for outline in alike]))
    starts = sorted(
        _starts(closed, like), key=lambda pose: _errors(pose, closed, cloud, coarse=True).max()
    )
    tried = [_refined(pose, closed, cloud) for pose in starts[:MOST]]
    if not tried:
        raise ValueError("its outlines do not lie as the contours of the drawing do")
    errors = np.array([_errors(pose, closed, cloud).max() for pose in tried])
    best, left = tried[int(errors.argmin())], float(errors.min())
    if left > FOUND:
        worst = int(_errors(best, closed, cloud).argmax())
        raise ValueError(f"{closed[worst].name} is not found where the other contours say")
    times, more = RIVAL
    for pose, error in zip(tried, errors, strict=True):
        turn = (pose.angle - best.angle + np.pi) % (2.0 * np.pi) - np.pi
        another = pose.mirrored != best.mirrored or abs(turn) > ASIDE
        if another and error < times * left + more:
            how = "mirrored" if pose.mirrored != best.mirrored else f"turned {np.degrees(turn):.0f}"
            raise ValueError(
                f"the drawing fits as well {how}{'' if how == 'mirrored' else ' deg'}: it needs a "
                "mark that is not symmetric"
            )
    return best


def _like(contour: DrawnContour, found: Sequence[Outline], wider: float) -> list[Outline]:
    """Outlines of its area, the nearest in area first."""
    area = contour.area_and_middle[0]
    largest = max(SIMILAR * area, wider * contour.curve.length)
    off = [(abs(outline.area - area), i) for i, outline in enumerate(found)]
    return [found[i] for difference, i in sorted(off) if difference < largest]


def _starts(closed: Sequence[DrawnContour], like: Sequence[Sequence[Outline]]) -> Iterator[Pose]:
    """Placements to try: two contours give the angle, a single one is turned around."""
    middle = np.array([contour.area_and_middle[1] for contour in closed])
    pairs = [(i, j) for i, j in combinations(range(len(closed)), 2)]
    pairs.sort(key=lambda pair: -np.linalg.norm(middle[pair[1]] - middle[pair[0]]))
    pairs = [(i, j) for i, j in pairs if np.linalg.norm(middle[j] - middle[i]) > APART]
    if not pairs:
        i = int(np.argmax([contour.area_and_middle[0] for contour in closed]))
        for outline in like[i][:10]:
            for degrees in range(0, 360, 5):
                for mirrored in (False, True):
                    yield _onto(np.radians(degrees), mirrored, middle[i], outline.middle)
    for i, j in pairs[:8]:
        apart = middle[j] - middle[i]
        for one in like[i]:
            for other in like[j]:
                between = other.middle - one.middle
                longer = np.linalg.norm(between) - np.linalg.norm(apart)
                if abs(longer) > LOOSE + STRETCHED * np.linalg.norm(apart):
                    continue
                for mirrored in (False, True):
                    sign = -1.0 if mirrored else 1.0
                    angle = np.arctan2(between[1], between[0])
                    angle -= np.arctan2(apart[1], sign * apart[0])
                    both = (0.5 * (middle[i] + middle[j]), 0.5 * (one.middle + other.middle))
                    yield _onto(float(angle), mirrored, *both)


def _onto(angle: float, mirrored: bool, point: Array, target: Array) -> Pose:
    """The placement by an angle that brings a point of the drawing onto one of the image."""
    x, y = target - Pose(0.0, 0.0, angle, mirrored).to_image(point[np.newaxis])[0]
    return Pose(float(x), float(y), angle, mirrored)


def _errors(
    pose: Pose, closed: Sequence[DrawnContour], cloud: KDTree, *, coarse: bool = False
) -> Array:
    """Error [m] of each contour, by the part of its points that fits best."""
    found = []
    for contour in closed:
        points = contour.coarse[0][:: max(1, len(contour.coarse[0]) // 24) if coarse else 1]
        distance = np.sort(cloud.query(pose.to_image(points))[0])
        found.append(np.sqrt(np.mean(distance[: int(TRIMMED * len(distance)) + 1] ** 2)))
    return np.array(found)


def _refined(pose: Pose, closed: Sequence[DrawnContour], cloud: KDTree, steps: int = 6) -> Pose:
    points, normals = (
        np.vstack(each) for each in zip(*(contour.coarse for contour in closed), strict=True)
    )
    for _ in range(steps):
        at, normal = pose.to_image(points), normals @ pose.matrix.T
        distance, i = cloud.query(at)
        near = distance <= np.quantile(distance, TRIMMED)
        off = np.einsum("ij,ij->i", cloud.data[i] - at, normal)
        pose = pose.moved(rigid_step(at[near] - [pose.x, pose.y], normal[near], off[near]))
    return pose


def rigid_step(lever: Array, normal: Array, off: Array) -> Array:
    """Motion (x, y [m], angle [rad]) that takes offsets (N,) [m] along normals (N, 2) away.

    lever: (N, 2) [m], from the centre of the rotation. Directions that the normals do not fix,
    such as the rotation of a circle, are not moved.
    """
    turned = lever[:, 0] * normal[:, 1] - lever[:, 1] * normal[:, 0]
    size = np.abs(lever).max()
    J = np.column_stack([normal, turned / size])
    step, *_ = np.linalg.lstsq(J, off, rcond=1e-4)
    return step / np.array([1.0, 1.0, size])


def own_outline(
    pose: Pose, contour: DrawnContour, found: Sequence[Outline], wider: float = WIDER
) -> Outline:
    """The outline of its area that lies nearest to a closed contour. wider: as `WIDER` [m]."""

    def apart(outline: Outline) -> float:
        distance = np.sort(KDTree(outline.points).query(at)[0])
        return float(distance[: int(TRIMMED * len(distance)) + 1].mean())

    at = pose.to_image(contour.coarse[0])
    middle = at.mean(axis=0)
    like = _like(contour, found, wider)
    like.sort(key=lambda outline: float(np.linalg.norm(outline.middle - middle)))
    return min(like[:4], key=apart)


def shift(pose: Pose, contour: DrawnContour, outline: Outline) -> Array:
    """(2,) [m], by which a closed contour lies beside its place: of a scanner's scale, mostly."""
    points, normals = contour.coarse
    at, normal = pose.to_image(points), normals @ pose.matrix.T
    cloud = KDTree(outline.points)
    moved = np.zeros(2)
    for _ in range(4):
        distance, i = cloud.query(at + moved)
        near = distance <= min(np.quantile(distance, TRIMMED), 2.0 * FOUND)
        off = np.einsum("ij,ij->i", cloud.data[i] - at - moved, normal)
        if near.sum() > 3:
            moved = moved + np.linalg.lstsq(normal[near], off[near], rcond=1e-2)[0]
    return moved


def followed(at: Array, normal: Array, outline: Outline) -> Array:
    """Points (N, 2) [m] of an expected edge, in order around it, moved along their normals to an
    outline; by the median of neighbours, so that a tear is not followed."""
    distance, i = KDTree(outline.points).query(at)
    off = np.einsum("ij,ij->i", outline.points[i] - at, normal)
    off = np.where(distance < FARTHEST, off, 0.0)
    return at + median_filter(off, MEDIAN, mode="wrap")[:, np.newaxis] * normal
