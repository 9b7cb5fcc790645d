"""One update by the scan of a part that a real robot has cut.

The motors' path, by which a scan is put in time, is that of the virtual robot of the type.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from armside.ilc.learning import LoopState
from armside.ilc.plant import Plant
from armside.ilc.workbench.compare import RunState

from ..motion.contour import Circle
from ..notes import Cause, Note
from ..part.arcs import Chain
from ..part.curve import ChainCurve, Kind
from ..part.motion import PartMotion
from ..scan.calibration import Calibration
from ..scan.image import ScanImage
from ..scan.reading import SheetScan, read_scan
from .experiment import Experiment, Pass
from .loop import loop_law
from .measures import SetUp
from .scan_measure import Place, ScannedPart, places

UNCORRECTED = 0.35e-3
"""Offset of a whole edge that a robot without correction may leave [m]. ESTIMATE: 0.25 mm were seen
around a small hole by the large robot. A drawing that is not looked for by its robot has less."""


@dataclass(kw_only=True)
class KnownScan:
    """Gives the same scan for every run."""

    scan: SheetScan

    def __call__(self, experiment: Experiment, run: Pass) -> SheetScan:
        return self.scan


def sheet_drawing(experiment: Experiment[PartMotion]) -> dict[str, ChainCurve]:
    """The beam's path along each contour, counter-clockwise where it is closed, in the plane of the
    part [m], as `read_scan` takes it."""
    return {one.name: _drawn(one)[0] for one in places(experiment)}


def pieces(experiment: Experiment[PartMotion]) -> Collection[str]:
    """Contours of `sheet_drawing` whose material lies inside."""
    each = zip(places(experiment), experiment.motion.cuts, strict=True)
    return [one.name for one, cut in each if cut.kind is Kind.OUTLINE]


def _drawn(one: Place) -> tuple[ChainCurve, bool]:
    """And whether it runs against the curve of the cut."""
    curve: Any = one.curve
    if isinstance(curve, Circle):
        points = curve.point(0.25 * curve.length * np.arange(5))
        points[-1] = points[0]
        chain = Chain(points, np.full(4, np.tan(np.pi / 8.0)))
    else:
        chain = curve.chain
    chain = Chain(chain.points + one.middle, chain.bulge)
    against = bool(chain.closed and chain.area < 0.0)
    return ChainCurve(chain.reversed if against else chain), against


def read_part_scan(
    image: ScanImage,
    experiment: Experiment[PartMotion],
    beam: float,
    calibration: Calibration | None = None,
) -> SheetScan:
    """Deviation of the beam across each contour by the scan of a part, along `sheet_drawing`.

    beam: diameter [m]. Raises ValueError as `read_scan`.
    """
    drawing, own = sheet_drawing(experiment), pieces(experiment)
    return read_scan(
        image, drawing, pieces=own, calibration=calibration, beam=beam, wider=UNCORRECTED
    )


def along_cuts(scan: SheetScan, experiment: Experiment[PartMotion]) -> SheetScan:
    """The same with contours that run as they are cut."""
    contours = dict(scan.contours)
    for one in places(experiment):
        drawn, against = _drawn(one)
        if against and (seen := contours.get(one.name)) is not None:
            s, d = drawn.length - seen.arc_length[::-1], -seen.deviation[::-1]
            contours[one.name] = replace(seen, arc_length=s, deviation=d)
    return replace(scan, contours=contours)


class Update(NamedTuple):
    """What a scan taught."""

    state: RunState
    """The next run with its correction, and the error of the one that was scanned."""
    notes: tuple[Note, ...]


def updated(
    experiment: Experiment[PartMotion],
    set_up_of: Callable[[ScannedPart], SetUp],
    plant: Plant[Pass],
    scans: tuple[SheetScan, SheetScan],
    before: RunState,
) -> Update:
    """One update of the correction that a part was cut with.

    set_up_of: of samples of the motors `measure.prepare`, of a program `contour_measure`.
    plant: the virtual robot, whose motors stand for those of the real one.
    scans: of `read_part_scan`, of the first part that was scanned and of this one.
    before: of the run that this part was cut in; its memory is None if no part was scanned before.

    Raises ValueError for a scan of something else.
    """
    first, last = (along_cuts(scan, experiment) for scan in scans)
    u, begun, memory = before.loop.correction, before.start, before.loop.memory
    known = KnownScan(scan=first)
    set_up = set_up_of(ScannedPart(scans=known, stiffness_error=0.0))
    output: Any = set_up(plant.run(np.zeros_like(u) if begun is None else begun))
    law = loop_law(output.law, output, experiment, begun)
    known.scan = last
    error = output.reference - output(plant.run(u))
    law.check(*error.shape)
    after, memory_after = law.step(u, error, memory)
    notes = output.notes
    if memory is not None and memory_after.setbacks > memory.setbacks:
        back = "the error had grown: learning went back to its best part"
        notes = (*notes, Note(cause=Cause.GUARD, text=back))
    size = output.size(error) if memory is None else before.loop.first_size
    loop = LoopState(before.loop.k + 1, after, error, memory_after, size)
    return Update(RunState(loop=loop, start=begun), notes)
