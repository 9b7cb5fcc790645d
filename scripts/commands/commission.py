"""`armside commission`: the digital twin of a robot individual, from a few cuts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.results import pass_notes
from armside.sim.motion.tool_motion import motion_notes
from armside.sim.notes import Cause, Note, Tally, counted
from armside.sim.part.arcs import MM
from armside.sim.records.run_folder import RUNS, check_writable
from armside.sim.records.summary import summary
from armside.sim.robot.alien import HYSTERESIS
from armside.sim.twin import commission as commissioning
from armside.sim.twin import parameters as of_twin
from armside.sim.twin.commission import (
    CANDIDATES,
    MOST,
    SENSORS,
    CommissionedTwin,
    plan,
    sensor_of,
)
from armside.sim.twin.coupon import coupon
from armside.sim.twin.identification import Identification
from armside.sim.twin.prediction import is_identified, standard_deviation
from armside.sim.twin.recordings import (
    MeasuredCut,
    SensorName,
    measured,
    notes_of_first_run,
    read_cut,
)
from armside.sim.twin.simulation import design_of
from armside.sim.twin.twin import Twin

from ..cutting.options import OF_ROBOT, IndividualCfg, robot_state
from ..shell.console import Report, run_folder
from ..shell.errors import InputError, checking_input, needs
from ..shell.options import (
    SEVERAL,
    Common,
    FileToRead,
    Limits,
    check_limits,
    options,
)

_SHEET = Limits(60.0, 420.0, "mm")  # the longer side of A3, of large flatbed scanners


@options
@dataclass(frozen=True, kw_only=True)
class CommissionCfg(IndividualCfg):
    """The robot, and the cuts that it is known from."""

    robot: Literal["large"] = "large"
    """Robot. A twin of the IRB1400 is not made yet: its arm closes a chain."""
    cuts: int = 4
    """Number of cuts, 1 to 10, from a plan that is chosen by what they identify."""
    measure: SensorName = "tracker"
    """Sensor at the tool: a laser tracker, an IMU that stays on the robot, or a scan of a coupon
    alone."""
    payload: float | None = None
    """Mass of the tool [kg] [default: as in the model]."""
    recordings: Annotated[tuple[Path, ...], SEVERAL] = ()
    """Runs to commission from, in place of cuts by the virtual robot: folders of `armside laser`,
    or tables of recorded data."""
    leave_out: Annotated[tuple[str, ...], SEVERAL] = ()
    """Names of cuts to leave out."""
    coupon: FileToRead = None
    """Scan of the coupon (PNG, TIFF), beside the plan that --coupon-sheet has written and the
    records of its cuts. With --measure imu or scan."""
    scanner: Path | None = None
    """scanner.json of `armside scan calibrate`, or its folder [default: the scanner is not
    calibrated]."""
    coupon_sheet: Path | None = None
    """Only write the coupon into this new folder: coupon.dxf and its plan. Of a virtual individual
    also the records of its cuts, and the scan."""
    sheet: tuple[float, float] = (160.0, 240.0)
    """Width and height of the coupon's sheet [mm]."""
    choose: bool = False
    """Only choose the plan anew, and print what each cut adds."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_limits(self, {"cuts": Limits(1, MOST), "payload": OF_ROBOT["payload"]})
        if self.recordings and self.individual is not None:
            raise ValueError("recordings are of a robot of their own: leave out --individual")
        if self.coupon is None and self.measure == "scan" and self.coupon_sheet is None:
            raise ValueError("measure scan needs the scan of a coupon: --coupon SCAN.png")
        if self.coupon is not None and self.measure == "tracker":
            raise ValueError("coupon goes with --measure imu or scan, not with tracker")
        if self.scanner is not None and self.coupon is None:
            raise ValueError("scanner is that of a coupon: give --coupon SCAN.png too")
        for side in self.sheet:
            _SHEET.check("sheet", side)


def commission(*, cfg: CommissionCfg = CommissionCfg(), common: Common = Common()) -> None:
    """Make the digital twin of a robot individual from a few cuts, for `armside laser --twin`.

    Writes summary.json, twin.json, covariance.npy, friction.png and residuals.png.
    """
    from ..figures import commission as figures

    report = Report(common)
    if cfg.choose:
        _choose(report, cfg)
        return
    if cfg.coupon_sheet is not None:
        _write_coupon(report, cfg, cfg.coupon_sheet, common.seed)
        return
    with checking_input():
        check_writable(common.out or RUNS / "commission")
        names = _names(cfg)
        chosen = {name: path for name, path in named(cfg.recordings).items() if name in names}
        recorded = [replace(read_cut(p, cfg.measure), name=name) for name, p in chosen.items()]
        notes = counted((notes_of_first_run(path) for path in chosen.values()), "cuts")
        of_sheet, more = _of_coupon(cfg)
    if not recorded and cfg.measure != "scan":
        recorded, notes = _cut(cfg, names, common.seed, report)
    recorded, notes = [*recorded, *of_sheet], [*notes, *more]
    steps = Identification().steps * len(recorded)
    with report.progress("identifying", total=steps) as step:
        found = commissioning.commission(
            recorded, robot=cfg.robot, payload=cfg.payload, measure=cfg.measure, progress=step
        )
    results = _results(found)
    by: list[SensorName] = [sensor_of(cut, cfg.measure) for cut in recorded]
    notes = [*notes, *_besides(found.twin), *_suspicious(results["cuts"], by)]
    outcome = summary("commission", cfg, common, notes=notes, **results)
    with run_folder(outcome, common) as folder:
        found.twin.save((folder / "summary.json").parent)
        figures.friction(folder / "friction.png", found, recorded)
        figures.residuals(folder / "residuals.png", found, recorded)
    report.notes(notes)
    _show(report, outcome, by)
    report.results(outcome, folder.path)


def _besides(twin: Twin) -> list[Note]:
    """Notes on what a twin knows beyond its type."""
    found = list[Note]()
    if twin.servo is not None:
        text = "the servo is not the type's: what it does besides is identified from the motors"
        found.append(Note(cause=Cause.TWIN, text=text))
    if twin.hysteresis:
        factor = float(twin.theta[twin.parameters.at(of_twin.HYSTERESIS.name)][0])
        text = (
            f"gears have hysteresis, {100.0 * factor * HYSTERESIS:.2g} % of their rated torque: it "
            "is identified, and corrections take four times as long"
        )
        found.append(Note(cause=Cause.TWIN, text=text))
    return found


def _suspicious(cuts: Sequence[dict[str, Any]], by: Sequence[SensorName]) -> list[Note]:
    """Notes on a sensor most of whose cuts a twin of the others does not explain."""
    found = list[Note]()
    for name in dict.fromkeys(by):
        sensor = SENSORS[name]
        own = zip(cuts, by, strict=True)
        left = [c["held_out"] for c, seen in own if seen == name and c["held_out"] is not None]
        usual = float(np.median(left)) if left else 0.0
        if usual > sensor.unsuspicious:
            text = (
                f"a twin of the other cuts leaves {sensor.factor * usual:.3g} {sensor.unit} of the "
                f"{sensor.quantity}: are all cuts of one robot with one tool?"
            )
            found.append(Note(cause=Cause.TWIN, text=text))
    return found


def _of_coupon(cfg: CommissionCfg) -> tuple[list[MeasuredCut], list[Note]]:
    """Records of the coupon that are not left out, with what the scan says, and its notes."""
    if cfg.coupon is None:
        return [], []
    from ..cutting.coupon import read_coupon

    with needs("scan", "commission --coupon", "scikit-image"):
        cuts, notes = read_coupon(cfg.coupon, cfg.scanner)
    return [cut for cut in cuts if cut.name not in cfg.leave_out], notes


def _write_coupon(report: Report, cfg: CommissionCfg, folder: Path, seed: int) -> None:
    from ..cutting.coupon import CONTOURS, cut_coupon, write_drawing

    sheet = (cfg.sheet[0] * MM, cfg.sheet[1] * MM)
    with checking_input(), needs("scan", "commission --coupon-sheet", "ezdxf"):
        coupon(sheet)
        if folder.exists():
            raise InputError(f"{folder} exists: give a folder that is new")
        folder.mkdir(parents=True)
        write_drawing(folder, sheet)
    if cfg.individual is not None:
        with report.progress("cutting", total=CONTOURS) as step:
            state = {"payload": cfg.payload, **robot_state(cfg)}
            cut_coupon(folder, sheet, state, seed, step)
    report.line(f"The coupon is in {folder}")


def _choose(report: Report, cfg: CommissionCfg) -> None:
    with report.progress("choosing", total=len(CANDIDATES)) as step:
        taken = commissioning.chosen(design_of(cfg.robot, cfg.payload), progress=step)
    rows = []
    for choice in taken:
        cut = CANDIDATES[choice.number]
        place = " ".join(f"{value:g}" for value in cut.tool_pose.position)
        kind = f"{type(cut.curve).__name__}, {1e3 * cut.curve.length:.0f} mm around"
        loaded = prepare(cut, seed=0).loaded
        seconds = f"{len(loaded.reference) * loaded.log_period:.1f}"
        rows.append([choice.number, kind, place, 1e3 * cut.speed, seconds, choice.gain])
    report.table(
        "Cuts in the order in which they are taken",
        ["candidate", "contour", "position [m]", "speed [mm/s]", "record [s]", "information [nat]"],
        rows,
    )


def _names(cfg: CommissionCfg) -> list[str]:
    """Names of the cuts to identify from. Raises ValueError for one to leave out that is not, and
    for one that is given twice."""
    virtual = [] if cfg.measure == "scan" else [f"cut-{i + 1}" for i in range(cfg.cuts)]
    of_sheet = [] if cfg.coupon is None else list(coupon())
    names = [*(list(named(cfg.recordings)) or virtual), *of_sheet]
    if unknown := [name for name in cfg.leave_out if name not in names]:
        raise ValueError(f"there is no cut {unknown[0]!r} to leave out. Cuts: {', '.join(names)}")
    if not (left := [name for name in names if name not in cfg.leave_out]):
        raise ValueError("every cut is left out")
    return left


def named(recordings: Sequence[Path]) -> dict[str, Path]:
    """Recordings by name: that of the file, or the path as given where several have it. Raises
    ValueError for one that is given twice."""
    paths = [str(path) for path in recordings]
    if twice := [path for path in paths if paths.count(path) > 1]:
        raise ValueError(f"the recording {twice[0]} is given twice")
    names = [path.name for path in recordings]
    return {
        name if names.count(name) == 1 else str(path): path
        for name, path in zip(names, recordings, strict=True)
    }


def _cut(
    cfg: CommissionCfg, names: list[str], seed: int, report: Report
) -> tuple[list[MeasuredCut], list[Note]]:
    cuts, tally = [], Tally()
    with report.progress("cutting", total=len(names)) as step:
        for i, planned in enumerate(plan(cfg.cuts)):
            if (name := f"cut-{i + 1}") not in names:
                continue
            with checking_input():
                imu = ImuCfg() if cfg.measure == "imu" else None
                cut = replace(planned, payload=cfg.payload, imu=imu, **robot_state(cfg))
                experiment = prepare(cut, seed=seed + i)
            run = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
            cuts.append(measured(run, name))
            tally.add((*motion_notes(experiment.motion, cut.limits), *pass_notes(experiment, run)))
            step()
    return cuts, tally.notes("cuts")


def _results(found: CommissionedTwin) -> dict[str, Any]:
    parameters, identified = found.twin.parameters, found.identified
    names = parameters.names
    deviation = standard_deviation(parameters, identified.covariance)
    known = is_identified(parameters, identified.covariance)
    values = zip(names, identified.theta, deviation, parameters.standard_deviation, strict=True)
    cuts = zip(found.twin.names, identified.held_out, identified.within, strict=True)
    return {
        "cuts": [{"name": n, "held_out": out, "within": within} for n, out, within in cuts],
        "torque_residual": found.twin.torque_residual,
        "parameters": [
            {"name": name, "value": value, "standard_deviation": s, "prior": p}
            for name, value, s, p in values
        ],
        "not_identified": [n for n, is_known in zip(names, known, strict=True) if not is_known],
    }


def _show(report: Report, outcome: dict[str, Any], sensors: Sequence[SensorName]) -> None:
    columns = ["cut", "in the identification", "held out"]
    for name in dict.fromkeys(sensors):
        sensor = SENSORS[name]
        rows = [
            [c["name"]]
            + ["-" if c[k] is None else sensor.factor * c[k] for k in ("within", "held_out")]
            for c, seen_by in zip(outcome["cuts"], sensors, strict=True)
            if seen_by == name
        ]
        head = f"What the twin leaves of the {sensor.quantity} [{sensor.unit}]"
        report.table(head, columns, rows)
    unknown, every = outcome["not_identified"], len(outcome["parameters"])
    kinds = sorted({name.split(" ")[0] for name in unknown})
    report.line(
        f"{every - len(unknown)} of {every} parameters are identified; of the others the cuts tell "
        f"nothing that matters to them: {', '.join(kinds) or 'none'}"
    )
