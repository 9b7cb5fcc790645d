"""What a scan of a cut sheet says: deviation of the beam across each contour, by arc length."""

from collections.abc import Mapping
from dataclasses import dataclass

from armside.arrays import Array

from ..notes import Note


@dataclass(frozen=True, kw_only=True)
class ScannedContour:
    """Where the beam was across one contour, of which a scan sees one edge or both.

    Nothing is known along the path, in height, or where the sheet lay in the robot's base.
    """

    arc_length: Array
    """(M,) [m], of the drawn contour, increasing; places that are torn or burred are not in it."""
    deviation: Array
    """(M,) [m], middle of the beam less the drawn contour, along `motion.contour.outward_normal`,
    after the placement of the sheet and half the beam are taken off."""
    noise: float
    """Standard deviation [m] of a value of `deviation` in a bin of 0.2 mm."""


@dataclass(frozen=True, kw_only=True)
class SheetScan:
    """Contours of one sheet as scanned, by their names on the drawing."""

    contours: Mapping[str, ScannedContour]
    placement: tuple[float, float, float]
    """x, y [m] and angle [rad] of the drawing in the image, by a best fit of all contours."""
    beam: float
    """Diameter [m], half of which was taken off."""
    beam_measured: bool
    """Whether a kerf with both edges visible gave the beam, or it was assumed."""
    scale: float
    """Standard deviation of the scanner's scale, a ratio: 1e-4 calibrated, 1e-3 not."""
    notes: tuple[Note, ...] = ()
