"""`armside cut --scan`: one update of a correction by the scan of the part that was cut with it."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.ilc.learning import LoopState
from armside.ilc.workbench.compare import RunState
from armside.sim.records.files import check_file, reading

from ..shell.console import Report
from ..shell.errors import InputError, needs
from ..shell.options import FileToRead, options
from .earlier import Earlier

if TYPE_CHECKING:
    from armside.sim.motion.contour import ClosedCurve
    from armside.sim.scan.reading import SheetScan

    from .cut_run import Ready
    from .part_options import CutCfg
    from .part_program import Learner

DRAWN = "part-scan.png"
"""A virtual scan."""
SCANS = "scans.json"
"""The first scan of a part, and digests of all."""
_FREE = {"measure", "iterations"}


@options
@dataclass(frozen=True, kw_only=True)
class PartScanCfg:
    """A part of yours that was cut and scanned."""

    scan: FileToRead = None
    """Scan of a part of yours. Cut with the correction of --from, or without any: one update is
    made of it, and the virtual robot runs once. See docs/scan.md."""
    scanner: Path | None = None
    """Calibration of its scanner. scanner.json of `armside scan calibrate`, or the folder; without
    one the scanner is not calibrated."""
    draw_scan: bool = False
    """Draw a virtual scan of the last part. Of the virtual robot, in part-scan.png."""

    def __post_init__(self) -> None:
        if self.scanner is not None and self.scan is None:
            raise ValueError("scanner is that of a scan: give --scan PART.png too")

    def asked(self, cfg: "CutCfg") -> "CutCfg":
        """Options of the cut, which learns from the scan alone. Raises ValueError for others."""
        if self.scan is None:
            return cfg
        if cfg.plan_only or cfg.twin is not None:
            other = "plan-only" if cfg.plan_only else "twin"
            raise ValueError(f"a scan is of a part that was cut: leave out --{other}")
        return replace(cfg, measure="scan", iterations=0)


@dataclass(frozen=True, kw_only=True)
class Taught:
    """What the scan of a part taught."""

    state: RunState
    entries: Mapping[str, Any]
    """Of `summary.json`."""
    kept: Mapping[str, Any] = field(repr=False)
    """Content of SCANS."""
    scan: "SheetScan" = field(repr=False)
    drawing: "Mapping[str, ClosedCurve]" = field(repr=False)
    notes: tuple[Any, ...] = ()

    def show(self, report: Report) -> None:
        """Table of its contours."""
        rows = [
            [of["contour"], *(1e6 * of[name] for name in ("rms", "max", "noise"))]
            for of in self.entries["contours"]
        ]
        head = ["contour", "RMS [µm]", "max [µm]", "noise [µm]"]
        k, rms = self.entries["k"], 1e6 * self.entries["rms"]
        report.table(f"Part of k = {k} by its scan: RMS {rms:.4g} µm", head, rows)
        report.line(f"The correction for k = {k + 1} is written; signals are the virtual robot's")


def taught(
    asked: PartScanCfg,
    cfg: "CutCfg",
    made: "Ready",
    learner: "Learner | None",
    before: Earlier | None,
) -> Taught:
    """One update by the scan of a part. Raises ValueError for a scan of something else."""
    from armside.sim.controller.programs import ProgramPlant
    from armside.sim.controller.programs.target_learning import contour_measure
    from armside.sim.laser.part_scan import read_part_scan, sheet_drawing, updated
    from armside.sim.scan.calibration import image_by, read_calibration

    assert asked.scan is not None
    experiment = made.experiment
    state, kept = _begun(before, experiment, 3 if learner else None)
    digest = sha256(asked.scan.read_bytes()).hexdigest()
    if digest in kept["digests"]:
        k = kept["digests"].index(digest)
        raise InputError(f"{asked.scan} is the scan of the part of k = {k}: scan the next one")
    calibration = None if asked.scanner is None else read_calibration(asked.scanner)
    with needs("scan", "armside cut --scan", "scikit-image"):
        seen = image_by(calibration, asked.scan)
        scan = read_part_scan(seen, experiment, 1e-3 * cfg.beam, calibration)
    first = scan if kept["first"] is None else _scan_of(kept["first"])
    if learner is None:
        plant, set_up_of = experiment.plant, lambda measure: measure.prepare(experiment)
    else:
        program = learner.program
        plant = ProgramPlant.of(program)
        set_up_of = lambda measure: contour_measure(program, measure)  # noqa: E731
    found = updated(experiment, set_up_of, plant, (first, scan), state)
    contours = [
        {
            "contour": name,
            "rms": float(np.sqrt(np.mean(of.deviation**2))),
            "max": float(np.abs(of.deviation).max()),
            "noise": of.noise,
        }
        for name, of in scan.contours.items()
    ]
    all_of_it = np.concatenate([of.deviation for of in scan.contours.values()])
    return Taught(
        state=found.state,
        entries={
            "file": asked.scan,
            "k": state.loop.k,
            "rms": float(np.sqrt(np.mean(all_of_it**2))),
            "contours": contours,
        },
        kept={"digests": [*kept["digests"], digest], "first": asdict(first)},
        scan=scan,
        drawing=sheet_drawing(experiment),
        notes=(*scan.notes, *found.notes),
    )


def _begun(
    before: Earlier | None, experiment: Any, inputs: int | None
) -> tuple[RunState, dict[str, Any]]:
    """State of the run that a part was cut in, and the scans before it. Raises InputError where
    the part was cut otherwise than these options say."""
    reference = experiment.loaded.reference
    nothing = {"digests": [], "first": None}
    if before is None:
        u = np.zeros((len(reference), inputs or reference.shape[1]))
        return RunState(loop=LoopState(0, u, u, None, np.zeros(1))), nothing
    if changed := sorted(set(before.changed) - _FREE):
        raise InputError(
            f"{before.run.folder} had another {', '.join(changed)}: a scan is of a part that was "
            "cut as that run says"
        )
    state = before.state()
    if "scan" in before.run.summary:
        with reading(file := before.run.file(SCANS)):
            return state, json.loads(check_file(file).read_text(encoding="utf-8"))
    u = state.loop.correction
    return RunState(
        loop=LoopState(0, u, u, None, np.zeros(1)), start=u if u.any() else None
    ), nothing


def _scan_of(stored: Mapping[str, Any]) -> "SheetScan":
    from armside.sim.scan.reading import ScannedContour, SheetScan

    contours = {
        name: ScannedContour(
            arc_length=np.array(of["arc_length"]),
            deviation=np.array(of["deviation"]),
            noise=of["noise"],
        )
        for name, of in stored["contours"].items()
    }
    rest = {name: stored[name] for name in ("beam", "beam_measured", "scale")}
    return SheetScan(contours=contours, placement=tuple(stored["placement"]), **rest)
