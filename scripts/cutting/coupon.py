"""The coupon of a twin on disk: its drawing, records of its cuts, and the scan of its sheet."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.sim.laser.experiment import Experiment, Pass, prepare
from armside.sim.laser.scan_measure import places
from armside.sim.motion.contour import Circle
from armside.sim.notes import Note
from armside.sim.part.arcs import MM
from armside.sim.part.motion import PartMotion
from armside.sim.records.files import InputError, check_file
from armside.sim.scan.image import enclosed
from armside.sim.scan.reading import SheetScan
from armside.sim.scan.virtual_reading import BeamPath, placement
from armside.sim.twin.coupon import PLACE, SHEET, beam_path, coupon, coupon_cut, drawing, scanned
from armside.sim.twin.recordings import MeasuredCut, read_cut

DRAWING, PLAN, SCAN, GRID = "coupon.dxf", "coupon.json", "scan.png", "grid.png"
CONTOURS = len(coupon())
_DPI = 600.0
"""Of a virtual scan."""
_MARGIN = 0.03
"""[m], of the bed around the sheet."""
_SPACING = 10e-6
"""[m], of the points of a virtual edge."""
_PITCH, _TURNED = 10e-3, 0.1
"""[m], [rad], of the virtual grid."""
_SAME = 1e-6
"""[rad], by which the reference of a record may differ from that of the plan."""


def write_drawing(folder: Path, sheet: tuple[float, float]) -> None:
    """The drawing [mm], each contour on a layer of its name, and the plan that `read_coupon` needs.

    sheet: width and height [m].

    Raises ValueError for a sheet that is too small, ModuleNotFoundError without ezdxf.
    """
    import ezdxf

    document = ezdxf.new(units=4)  # pyright: ignore[reportPrivateImportUsage]
    space = document.modelspace()
    contours = coupon(sheet)
    for name, curve in drawing(sheet).items():
        chain = curve.chain
        one = contours.get(name)
        if name == "mark" or (one is not None and isinstance(one.curve, Circle)):
            middle = chain.points[:2].mean(axis=0) / MM
            radius = 0.5 * float(np.linalg.norm(chain.points[1] - chain.points[0])) / MM
            space.add_circle(tuple(middle), radius, dxfattribs={"layer": name})
            continue
        bulge = np.append(chain.bulge, 0.0)
        points = np.column_stack([chain.points / MM, bulge])
        closed = chain.closed
        drawn = points[: -1 if closed else None].tolist()
        space.add_lwpolyline(drawn, format="xyb", close=closed, dxfattribs={"layer": name})
    document.saveas(folder / DRAWING)
    cuts = [
        {"name": n, "middle": one.middle, "speed": one.speed, "clockwise": one.clockwise}
        for n, one in contours.items()
    ]
    content = {"sheet": sheet, "place": PLACE, "contours": cuts}
    (folder / PLAN).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def cut_coupon(
    folder: Path,
    sheet: tuple[float, float],
    state: dict[str, Any],
    seed: int,
    step: Callable[[], None],
) -> None:
    """Records of the coupon as a virtual robot cuts it, the scan of the sheet, and one of a grid of
    10 mm on the same scanner.

    state: of the robot, fields of `Cut`.
    """
    from armside.sim.records.signals import RecordedRun, write_signals

    paths = dict[str, BeamPath]()
    for i, (name, one) in enumerate(coupon(sheet).items()):
        experiment = prepare(replace(coupon_cut(one), **state), seed=seed + i)
        run: Pass = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
        paths[name] = beam_path(one, experiment, run)
        (folder / name).mkdir()
        write_signals(
            folder / name / "signals.parquet",
            [RecordedRun(k=0, recording=run.recording, tracker=run.tracker)],
            config={"coupon": name},
            seed=seed + i,
            truth_rate=250.0,
            motion=experiment.motion,
            gear=experiment.loaded.model.drives.gear,
        )
        step()
    _save_scans(folder, sheet, paths, seed)


def _save_scans(
    folder: Path, sheet: tuple[float, float], paths: dict[str, BeamPath], seed: int
) -> None:
    from armside.sim.scan.virtual import Process, Sheet, grid

    rng, process = np.random.default_rng(seed), Process()
    _, pose = placement([(one.curve, one.middle, one.path) for one in paths.values()])
    regions = list[tuple[Array, bool]]()
    for name, curve in drawing(sheet).items():
        one = paths.get(name)
        if one is None:
            path = pose.to_image(curve.point(np.arange(0.0, curve.length, _SPACING)))
        else:
            path = _dense(one.path[::-1] if one.clockwise else one.path)
        edge = process.kerf(path, rng) if name == "kerf" else process.edge(path, 1, rng)
        regions.append((edge, False))
    size = sheet[0] + _MARGIN, sheet[1] + _MARGIN
    place = 0.5 * size[0], 0.5 * size[1], float(rng.uniform(-0.02, 0.02))
    cells = round(sheet[0] / _PITCH), round(size[1] / _PITCH)
    c, s = np.cos(_TURNED), np.sin(_TURNED)
    x, y = 0.5 * np.array(size) - 0.5 * _PITCH * np.array([[c, -s], [s, c]]) @ cells
    _save(folder / SCAN, Sheet(regions=regions), place, size, seed, rng)
    _save(folder / GRID, grid(_PITCH, cells), (float(x), float(y), _TURNED), size, seed, rng)


def _save(
    file: Path,
    sheet: Any,
    place: tuple[float, float, float],
    size: tuple[float, float],
    seed: int,
    rng: np.random.Generator,
) -> None:
    """The scan of a sheet on the scanner of a seed."""
    from PIL import Image

    from armside.sim.scan.virtual import drawn_scanner
    from armside.sim.scan.virtual import scanned as image_of

    scanner = drawn_scanner(np.random.default_rng([seed, 0x5CA]), dpi=_DPI)
    found = image_of(sheet, scanner, size, rng, place=place)
    Image.fromarray(found.grey).save(file, dpi=found.dpi)


def draw_part(file: Path, experiment: Experiment[PartMotion], run: Pass, seed: int) -> None:
    """The scan of a virtual part on that scanner, an area as large as a coupon's.

    Raises InputError for a part that does not fit into it.
    """
    from armside.sim.laser.part_scan import pieces
    from armside.sim.scan.virtual import Process, Sheet

    (time, position), own = run.true, pieces(experiment)
    rng, process = np.random.default_rng([seed, 1]), Process()
    regions, beams = list[tuple[Array, bool]](), list[Array]()
    for one, cut in zip(places(experiment), experiment.motion.cuts, strict=True):
        on, piece = (time >= one.begin) & (time < one.end), one.name in own
        path = _dense(experiment.cut.plane.from_base(position[on])[:, :2], closed=cut.turn.closed)
        beams.append(path)
        if not cut.turn.closed:
            regions.append((process.kerf(path, rng), False))
            continue
        path = path if enclosed(path)[0] > 0.0 else path[::-1]
        regions.append((process.edge(path, -1 if piece else 1, rng), piece))
    points = np.vstack(beams)
    size = SHEET[0] + _MARGIN, SHEET[1] + _MARGIN
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    if (np.ptp(points, axis=0) > np.array(SHEET)).any():
        most = " by ".join(f"{1e3 * side:g}" for side in SHEET)
        raise InputError(f"the part is larger than {most} mm, which are scanned")
    x, y = 0.5 * np.array(size) - middle
    regions.sort(key=lambda each: not each[1])  # the material first, then its holes
    seen = Sheet(regions=regions, everywhere=not own)
    _save(file, seen, (float(x), float(y), float(rng.uniform(-0.02, 0.02))), size, seed, rng)


def _dense(path: Array, *, closed: bool = True) -> Array:
    """Points (N, 2) [m] of a path, `_SPACING` apart."""
    ends = np.vstack([path, path[:1]]) if closed else path
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
    at = np.arange(0.0, along[-1], _SPACING)
    return np.column_stack([np.interp(at, along, column) for column in ends.T])


def read_coupon(scan: Path, scanner: Path | None) -> tuple[list[MeasuredCut], list[Note]]:
    """Records of the cuts of a coupon, which lie with its plan beside the scan, and what the scan
    says of each; and notes of the scan.

    Raises InputError for a file that is missing, or of another coupon.
    """
    plan = scan.parent / PLAN
    if not plan.is_file():
        raise InputError(f"{scan.parent} holds no {PLAN}: `armside commission --coupon-sheet` does")
    try:
        content = json.loads(check_file(plan).read_text(encoding="utf-8"))
        wide, high = (float(value) for value in content["sheet"])
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{plan} is no plan of a coupon: {error}") from error
    contours, seen = coupon((wide, high)), _read_scan(scan, scanner, (wide, high))
    cuts = list[MeasuredCut]()
    if missing := [name for name in contours if not (scan.parent / name).exists()]:
        where = f"{scan.parent} has no record of the cut of {missing[0]}"
        raise InputError(f"{where}: a folder or table of that name beside the scan (docs/scan.md)")
    for name, one in contours.items():
        log = read_cut(scan.parent / name, "scan")
        experiment = prepare(coupon_cut(one), seed=0)
        asked = experiment.loaded.reference
        if log.reference.shape != asked.shape or np.abs(log.reference - asked).max() > _SAME:
            raise InputError(f"{scan.parent / name}: its reference is not that of the coupon's cut")
        times = experiment.motion.contour_time
        cuts.append(scanned(replace(log, name=name), name, contours, seen, times))
    return cuts, list(seen.notes)


def _read_scan(scan: Path, scanner: Path | None, sheet: tuple[float, float]) -> SheetScan:
    from armside.sim.scan.calibration import image_by, read_calibration
    from armside.sim.scan.reading import read_scan

    calibration = None if scanner is None else read_calibration(scanner)
    return read_scan(image_by(calibration, scan), drawing(sheet), calibration=calibration)
