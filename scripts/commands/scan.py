"""`armside scan`: a flatbed scanner as the sensor: calibrated by a grid, and a cut sheet read."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from armside.sim.part.arcs import MM
from armside.sim.part.drawing import Reading, Unit
from armside.sim.records.summary import dumps, summary

from ..shell.console import Report, run_folder
from ..shell.errors import InputError, checking_input, needs
from ..shell.options import Common, FileToRead, Limits, check_limits, options

if TYPE_CHECKING:
    from armside.sim.motion.contour import ClosedCurve
    from armside.sim.scan.reading import SheetScan

_CALIBRATE = "Make scanner.json of scans of a grid of lines."
_READ = "Read the scan of a cut sheet."
Action = Annotated[
    Literal["calibrate", "read"], Parameter(help=f"calibrate: {_CALIBRATE} read: {_READ}")
]
LIMITS = {
    "pitch": Limits(2.0, 20.0, "mm"),
    "dpi": Limits(500.0, 10_000.0),
    "beam": Limits(0.01, 2.0, "mm"),
    "gamma": Limits(0.3, 4.0),
}
OF = {
    "calibrate": ("pitch", "gamma"),
    "read": ("contours", "scanner", "beam", "drawn", "piece", "layers", "units"),
}
"""Options of each action alone."""


@options
@dataclass(frozen=True, kw_only=True)
class ScanCfg:
    """Grid, drawing and scanner."""

    pitch: float | None = None
    """Of calibrate: distance of the grid's lines [mm]."""
    gamma: float | None = None
    """Of calibrate: of the greys of this scanner's files [default: what a file says of itself, and
    linear if it says nothing]."""
    contours: FileToRead = None
    """Of read: drawing of the sheet (DXF, SVG, TOML). A part, if one contour lies around all the
    others; else each is a hole in the sheet."""
    scanner: Path | None = None
    """Of read: scanner.json of `calibrate`, or the folder that has it [default: not calibrated]."""
    dpi: float | None = None
    """Resolution, where the file has none or a wrong one."""
    beam: float | None = None
    """Of read: diameter of the beam [mm] [default: that of the open kerfs, or 0.2]."""
    drawn: Literal["edge", "beam"] | None = None
    """Of read: what a closed contour is drawn as, the part's edge, or the middle of the beam, as of
    a coupon [default: edge]."""
    piece: bool | None = None
    """Of read: a drawing of one contour is the piece that was cut out [default: its hole]."""
    layers: Annotated[tuple[str, ...], Parameter(consume_multiple=True, show_default=False)] = ()
    """Of read: layers of the drawing [default: all that are visible]."""
    units: Literal["mm", "inch"] | None = None
    """Of read: unit of the drawing, where it does not say its own or a wrong one."""

    def __post_init__(self) -> None:
        check_limits(self, LIMITS)


def scan(
    action: Action,
    /,
    *images: Path,
    cfg: ScanCfg = ScanCfg(),
    common: Common = Common(),
) -> None:
    """See what a robot cut by a scan of the sheet: PNG or TIFF, grey or colour, 500 dpi or more.

    images: of `calibrate` one or more scans of a grid, turned by some degrees; of `read` one scan.
    calibrate writes scanner.json; read deviation.csv and scan.png. See docs/scan.md.
    """
    report = Report(common)
    _check(action, images, cfg)
    with needs("scan", "armside scan", "scikit-image"):
        import skimage.measure  # noqa: F401
    if action == "calibrate":
        _calibrate(images, cfg, common, report)
    else:
        _read(images[0], cfg, common, report)


def _check(action: str, images: tuple[Path, ...], cfg: ScanCfg) -> None:
    for other in OF:
        for name in OF[other]:
            if other != action and getattr(cfg, name) not in (None, ()):
                raise InputError(f"{name} is of armside scan {other}")
    if action == "calibrate" and cfg.pitch is None:
        raise InputError("say the distance of the grid's lines: --pitch, in mm")
    if action == "read" and cfg.contours is None:
        raise InputError("say the drawing of the sheet: --contours")
    if not images or (action == "read" and len(images) > 1):
        raise InputError(f"armside scan {action} reads {'one image' if images else 'an image'}")


def _calibrate(images: tuple[Path, ...], cfg: ScanCfg, common: Common, report: Report) -> None:
    from armside.sim.scan.calibration import FILE, calibrated
    from armside.sim.scan.image import read_image

    assert cfg.pitch is not None
    with checking_input():
        seen = [read_image(file, cfg.dpi, cfg.gamma) for file in images]
        found = replace(calibrated(seen, MM * cfg.pitch), gamma=cfg.gamma)
    (sx, skew), (_, sy) = found.matrix.tolist()
    entries = {
        "scale_x": sx - 1.0,
        "scale_y": sy - 1.0,
        "skew": skew,
        "wobble": float(np.ptp(found.wobble[:, 1])),
        "wobble_sideways": float(np.ptp(found.wobble[:, 0])),
        "residual": found.residual,
        "heights": (float(found.y[0]), float(found.y[-1])),
    }
    given = {"action": "calibrate", "images": images, **_given(cfg)}
    outcome = summary("scan", given, common, **entries)
    with run_folder(outcome, common) as folder:
        (folder / FILE).write_text(dumps(found.as_json()), encoding="utf-8")
    report.table(
        "Scanner: what is taken off each scan, and what a grid is left with",
        ["x [%]", "y [%]", "skew [mrad]", "wobble [µm]", "sideways [µm]", "left [µm RMS]"],
        [
            [
                *(100.0 * entries[name] for name in ("scale_x", "scale_y")),
                1e3 * skew,
                *(1e6 * entries[name] for name in ("wobble", "wobble_sideways", "residual")),
            ]
        ],
    )
    report.results(outcome, folder.path)


def _read(file: Path, cfg: ScanCfg, common: Common, report: Report) -> None:
    from armside.sim.scan.calibration import image_by, read_calibration
    from armside.sim.scan.drawing import read_drawing
    from armside.sim.scan.reading import read_scan

    from ..figures.scan import scan_map

    assert cfg.contours is not None
    with checking_input():
        calibration = None
        if cfg.scanner is not None:
            calibration = read_calibration(cfg.scanner)
        try:
            unit = None if cfg.units is None else Unit(cfg.units)
            drawing = read_drawing(
                cfg.contours, Reading(layers=cfg.layers, unit=unit), piece=cfg.piece
            )
        except ModuleNotFoundError as error:
            raise InputError("drawings need the extra: pip install 'armside[scan]'") from error
        found = read_scan(
            image_by(calibration, file, cfg.dpi),
            drawing.contours,
            pieces=drawing.pieces,
            calibration=calibration,
            beam=None if cfg.beam is None else MM * cfg.beam,
            edges=cfg.drawn != "beam",
        )
    notes = [*drawing.notes, *(note.text for note in found.notes)]
    entries = described(found, drawing.contours)
    given = {"action": "read", "image": file, "drawn": "edge", **_given(cfg)}
    what = "beam" if cfg.drawn == "beam" else "edge"
    outcome = summary("scan", given, common, **entries, notes=notes)
    with run_folder(outcome, common) as folder:
        (folder / "deviation.csv").write_text(table_of(found), encoding="utf-8")
        title = f"{file.name}: where the {what} lies beside {cfg.contours.name}"
        scan_map(folder / "scan.png", found, drawing.contours, title, what)
    head = ["contour", "length [mm]", "size error [µm]", "max [µm]", "RMS [µm]", "noise [µm]"]
    names = ("size_error", "max", "rms", "noise")
    rows = [
        [of["contour"], 1e3 * of["length"], *(_microns(of[name]) for name in names)]
        for of in entries["contours"]
    ]
    missing = "an open cut has no size"
    title = f"Deviation across each contour: the {what} from where it is drawn (--drawn)"
    report.table(title, head, rows, missing=missing)
    report.notes(notes)
    report.results(outcome, folder.path)


def _microns(metres: float | None) -> float | None:
    return None if metres is None else 1e6 * metres


def _closed(curve: "ClosedCurve") -> bool:
    return bool(np.allclose(curve.point(0.0), curve.point(curve.length), atol=1e-6))


def _given(cfg: ScanCfg) -> dict[str, Any]:
    return {name: value for name in cfg.__dataclass_fields__ if (value := getattr(cfg, name))}


def described(found: "SheetScan", drawing: "Mapping[str, ClosedCurve]") -> dict[str, Any]:
    """Entries of the summary, in SI units. size_error: of a diameter or width, None of an
    open cut."""
    contours = [
        {
            "contour": name,
            "length": drawing[name].length,
            "size_error": 2.0 * float(of.deviation.mean()) if _closed(drawing[name]) else None,
            "max": float(np.abs(of.deviation).max()),
            "rms": float(np.sqrt(np.mean(of.deviation**2))),
            "noise": of.noise,
        }
        for name, of in found.contours.items()
    ]
    return {
        "contours": contours,
        "placement": found.placement,
        "beam": found.beam,
        "beam_measured": found.beam_measured,
        "scale": found.scale,
    }


def table_of(found: "SheetScan") -> str:
    """Text of deviation.csv: contour, arc length and deviation [mm]."""
    lines = ["contour,arc_length_mm,deviation_mm"]
    for name, of in found.contours.items():
        quoted = '"' + name.replace('"', '""') + '"'
        lines += [
            f"{quoted},{1e3 * s:.4f},{1e3 * d:.5f}"
            for s, d in zip(of.arc_length.tolist(), of.deviation.tolist(), strict=True)
        ]
    return "\n".join(lines) + "\n"
