"""Paths of the tool as a replay draws them: across the programmed path, magnified or coloured."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armside import kinematics
from armside.arrays import Array

from ..motion.tool_motion import ToolMotion
from ..part.motion import PartMotion
from ..records.signals import RecordedRun

MAGNIFICATIONS = (50.0, 20.0, 10.0, 5.0, 2.0)
LARGEST_SHOWN = 0.75
"""Largest magnified deviation, relative to the contour's half size."""
INSIDE, NEUTRAL, OUTSIDE = (
    np.array(rgb) for rgb in ([40, 80, 220], [190, 190, 190], [210, 30, 40])
)
"""Colours of a part's largest deviation to the left of its path, of none, and to the right."""


class Contour:
    """Programmed, motor-side and true tool path of one run in the plane, at the log's instants."""

    def __init__(
        self, run: RecordedRun, motion: ToolMotion | PartMotion, robot: kinematics.CompiledRobot
    ) -> None:
        recording, plane = run.recording, motion.plane
        self.time = recording.time
        self.programmed = plane.from_base(motion.position_at(self.time))[:, :2]
        self.cutting = motion.is_on_contour(self.time)
        self.normal = _normals(self.programmed)
        edges = np.flatnonzero(np.diff(self.cutting)) + 1
        spans = [slice(a, b) for a, b in zip([0, *edges], [*edges, len(self.time)], strict=True)]
        self.pieces = [span for span in spans if self.cutting[span.start]]
        """Samples of each contour, without leads."""
        self.between = [span for span in spans if not self.cutting[span.start]]
        """Samples of leads and rapid moves."""
        motor = robot.pose(recording.motor_angle)[:, :3, 3]
        self.motor = self._deviation(plane.from_base(motor)[:, :2])
        row = np.searchsorted(recording.truth.time, self.time - 1e-9)
        self.tool = self._deviation(plane.from_base(recording.truth.tool_position[row])[:, :2])

    def _deviation(self, p: Array) -> Array:
        """(N,) [m], across the path, outwards on a counter-clockwise contour, less the mean while
        cutting (static deflection): the shape remains."""
        offset = p - self.programmed
        offset = offset - offset[self.cutting].mean(axis=0)
        return np.einsum("ij,ij->i", offset, self.normal)

    def magnified(self, deviation: Array | float, factor: float) -> Array:
        """(N, 2) [mm], y upwards in Rerun's picture axes, which point down."""
        p = self.programmed + factor * np.expand_dims(deviation, -1) * self.normal
        return 1e3 * p * [1.0, -1.0]

    def cut(self, deviation: Array | float, factor: float) -> list[Array]:
        """Samples of `magnified` on each contour, without leads: (M, 2) [mm]."""
        points = self.magnified(deviation, factor)
        return [points[piece] for piece in self.pieces]

    @property
    def is_part(self) -> bool:
        """Several contours: their deviation is a colour, as small ones magnified are tangles."""
        return len(self.pieces) > 1

    @property
    def worst(self) -> float:
        """[m], the tool's largest deviation on a contour, of which a part's colours are a scale."""
        return float(np.abs(self.tool[self.cutting]).max())

    def coloured(self, factor: float, step: int = 1) -> tuple[list[Array], NDArray[np.uint8]]:
        """Pieces of the tool's path of `step` samples on all contours, and their colours (M, 3)."""
        points, scale = self.magnified(self.tool, factor), max(self.worst, 1e-12)
        spans = [
            slice(i, min(i + step + 1, piece.stop))
            for piece in self.pieces
            for i in range(piece.start, piece.stop - 1, step)
        ]
        at = np.clip(self.tool[[span.start for span in spans]] / scale, -1.0, 1.0)[:, np.newaxis]
        end = np.where(at < 0.0, INSIDE, OUTSIDE)
        strips = [points[span] for span in spans]
        return strips, np.rint(NEUTRAL + np.abs(at) * (end - NEUTRAL)).astype(np.uint8)

    @property
    def half_size(self) -> float:
        """[m], half the larger side of the programmed path."""
        return float(np.ptp(self.programmed, axis=0).max()) / 2

    def spectrum(self, deviation: Array) -> tuple[Array, Array]:
        """Frequencies [Hz] and amplitudes [m] of a deviation across the path while cutting."""
        cut = deviation[self.cutting]
        window = np.hanning(len(cut))
        amplitude: Array = 2.0 * np.abs(np.fft.rfft(cut * window)) / window.sum()
        frequency = np.fft.rfftfreq(len(cut), float(self.time[1] - self.time[0]))
        return np.asarray(frequency, dtype=np.float64), amplitude


def fitting_magnification(contours: Sequence[Contour]) -> float:
    """Largest of 50, 20, 10, 5, 2, 1 that leaves the contour's shape visible; of a part 1."""
    if any(c.is_part for c in contours):
        return 1.0
    largest = max(c.worst for c in contours)
    room = LARGEST_SHOWN * contours[0].half_size
    return next((m for m in MAGNIFICATIONS if m * largest <= room), 1.0)


def _normals(p: Array) -> Array:
    """Unit normals to the right of a path (N, 2); at rest that of the nearest moving sample."""
    step = np.gradient(p, axis=0)
    length = np.linalg.norm(step, axis=1)
    moving = np.flatnonzero(length > 1e-9)
    if not len(moving):
        return np.tile([1.0, 0.0], (len(p), 1))
    nearest = moving[np.clip(np.searchsorted(moving, np.arange(len(p))), 0, len(moving) - 1)]
    tangent = step[nearest] / length[nearest, np.newaxis]
    return np.column_stack([tangent[:, 1], -tangent[:, 0]])
