"""`armside program`: a program in RAPID, KRL or URScript, described, learned by hand, or run."""

import json
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from armside.ilc.workbench.compare import RunState, save_states
from armside.sim.controller.programs import ProgramText, read_program_file, rows_of
from armside.sim.motion.instructions import MoveL, Wait
from armside.sim.recordings.recorded_motion import MotionRecording
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary
from armside.sim.robot_file.find import check_named

from ..cutting.earlier import KEY, STATE, Earlier, FromCfg, started
from ..shell.console import Report
from ..shell.errors import InputError, checking_input
from ..shell.options import Common, Limits, check_read, options

Action = Annotated[
    Literal["read", "learn", "run"],
    Parameter(
        help="Describe the program of a file, learn its targets from a recorded run, or run it on "
        "the virtual robot and record that."
    ),
]
_FILE = ".mod (RAPID), .src with the .dat beside it (KRL), or .script (URScript)."
File = Annotated[Path, Parameter(help=_FILE, validator=check_read)]


@options
@dataclass(frozen=True, kw_only=True)
class ProgramCfg:
    """Options of learn and run."""

    recording: Path | None = None
    """Recording of a run of the program: a folder with encoders.* and tracker.* or imu.*, a bag or
    a run of armside (docs/real.md). It begins at rest before the first contour."""
    measure: Literal["tracker", "estimate", "motor"] | None = None
    """What is learned from: a laser tracker in the axes of the robot's base; an IMU with encoders;
    encoders alone [default: tracker, or as in --from]."""
    robot: str = "large"
    """Robot that runs it: large, irb1400, or a robot file."""
    payload: float | None = None
    """Mass of the tool [kg] [default: as in the robot's model]. The controller knows it."""
    individual: int | None = None
    """Of run: number of the virtual robot in the production line [default: the design with a
    friction of its own]."""

    def __post_init__(self) -> None:
        check_named(self.robot)
        if self.payload is not None:
            Limits(0.0, 1e4, "kg").check("payload", self.payload)
        Limits(0).check("individual", self.individual)


def program(
    action: Action,
    file: File,
    /,
    *,
    cfg: ProgramCfg = ProgramCfg(),
    of: FromCfg = FromCfg(),
    common: Common = Common(),
) -> None:
    """Read a robot's program, learn its targets from a recording of its run, or run it.

    read: moves, targets, spacing, zones, speeds, blocks a second. What is not understood (loops,
    conditions, time in place of speed) is refused with line and column, and nothing is skipped.
    learn: writes the program of the next run, other numbers in it and every other byte as it was,
    and a state that --from goes on from. FILE is always the program of the first run.
    run: what a recording of the virtual robot is, encoders.csv, tracker.csv and imu.csv. See
    docs/programs.md.
    """
    report = Report(common)
    with checking_input():
        read = read_program_file(file)
        if action == "learn":
            return _learn(report, read, file, cfg, of.start, common)
        if action == "run":
            if cfg.recording is not None or of.start is not None:
                raise InputError("recording and from are of `program learn`: run makes a recording")
            return _run(report, read, file, cfg, common)
        if cfg != ProgramCfg() or of.start is not None:
            raise InputError(
                "options other than --quiet and --json are of `program learn` and `run`"
            )
        found = described(read)
    outcome = summary("program", {"action": action, "file": file}, common, **found)
    report.kept(outcome, *_lines(found))
    rows = []
    for row in found["rows"]:
        spacing, zone, speed = (row[key] for key in ("spacing", "zones", "speeds"))
        mm = [1e3 * value for value in (*spacing, zone[1], speed[1])]
        rows.append([*row["lines"], row["targets"], *mm, row["blocks_per_second"]])
    report.table("Rows of linear moves, distances of targets [mm], [mm/s]", ROW, rows)


def _learn(
    report: Report,
    read: ProgramText,
    file: Path,
    cfg: ProgramCfg,
    start: Path | None,
    common: Common,
) -> None:
    from armside.sim.controller.programs.recorded_run import learned_from
    from armside.sim.recordings import read_motion

    if cfg.individual is not None:
        raise InputError("individual is of `program run`: learn knows its robot by the recording")
    if cfg.recording is None:
        raise InputError("learn needs --recording: the folder of a recording of the program's run")
    _refuse_corrected(file)
    cfg, common, before = started(start, "program", cfg, common)
    measure = cfg.measure or "tracker"
    assert cfg.recording is not None
    digest = sha256("".join(text.content for text in read.texts).encode("latin-1")).hexdigest()
    first, state, used = cfg.recording, None, list[str]()
    last = read_motion(cfg.recording)
    recordings = last, last
    if before is not None:
        first, state = _first_of(before, file, digest), before.state().loop
        recordings, used = (read_motion(first), last), list(before.run.summary["recordings"])
        if _digest(recordings[0]) != used[0]:
            raise InputError(f"{first} is not as it was in the first run, whose recording it was")
        if _digest(last) in used:
            k = used.index(_digest(last))
            raise InputError(
                f"{cfg.recording} is the recording of run k = {k}: record run {state.k}"
            )
    found = learned_from(read, cfg.robot, measure, recordings, state, cfg.payload)
    entries = {
        "status": "done",
        "file": file,
        "digest": digest,
        "first_recording": first.resolve(),
        "recordings": [*used, _digest(last)],
        "k": found.state.k - 1,
        "rms": found.rms,
        "targets": len(found.offsets),
        "changed": found.changed,
        "largest_offset": found.largest_offset,
        "program": found.texts[0].name,
        "notes": [*found.notes, *dict.fromkeys(note for each in recordings for note in each.notes)],
    }
    given = {"action": "learn", **asdict(cfg), "measure": measure}
    outcome = summary("program", given, common, **entries)
    with RunFolder("program", seed=common.seed, out=common.out) as folder:
        for text in found.texts:
            (folder / text.name).write_bytes(text.content.encode("latin-1"))
        save_states(folder / STATE, {KEY: RunState(loop=found.state)})
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    report.notes(entries["notes"])
    report.lines(
        [
            f"Run k = {entries['k']}: RMS {1e6 * found.rms:.4g} µm by {measure}",
            f"{folder.path / found.texts[0].name}: {found.changed} of {len(found.offsets)} targets "
            f"changed, largest offset {1e3 * found.largest_offset:.3g} mm",
        ]
    )
    report.results(outcome, folder.path)


WAITS = 100
"""Samples that a virtual robot waits before a program, as a recorder is started by hand."""


def _run(report: Report, read: ProgramText, file: Path, cfg: ProgramCfg, common: Common) -> None:
    """One run on the virtual robot."""
    from armside.sim.controller.programs.own_program import ProgramCut, own_program
    from armside.sim.instruments.imu import ImuCfg
    from armside.sim.laser.experiment import CuttingPlant
    from armside.sim.recordings.recorded_motion import Stream
    from armside.sim.recordings.tables import write_motion_tables
    from armside.sim.robot.spread import Drawn
    from armside.sim.robot.virtual_robot import VirtualRobot

    robot = None if cfg.individual is None else Drawn(cfg.individual)
    cut = ProgramCut(
        program=read, robot=cfg.robot, payload=cfg.payload, individual=robot, imu=ImuCfg()
    )
    program = own_program(cut, seed=common.seed)
    plant, rows = program.experiment.plant, [stretch.row for stretch in program.stretches]
    reference = program.run(rows).reference
    reference = np.vstack([np.repeat(reference[:1], WAITS, axis=0), reference])
    loaded = VirtualRobot(plant.loaded.model, nominal=program.controller).load(reference)
    run = CuttingPlant(loaded, plant.tracker, plant.rng, plant.imu).run(np.zeros_like(reference))
    imu, log = run.imu, run.recording
    assert imu is not None
    recording = MotionRecording(
        name=file.stem,
        encoders=Stream(log.time, log.motor_angle),
        tracker=Stream(run.tracker.time, run.tracker.position),
        imu=Stream(imu.time, np.hstack([imu.acceleration, imu.angular_velocity])),
        form="run of a program",
    )
    entries = {"status": "done", "file": file, "seconds": float(log.time[-1])}
    outcome = summary("program", {"action": "run", **asdict(cfg)}, common, **entries)
    with RunFolder("program", seed=common.seed, out=common.out) as folder:
        write_motion_tables((folder / "summary.json").parent, recording, "csv")
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    report.line(f"{file.name} on the virtual robot: {log.time[-1]:.3g} s recorded")
    report.results(outcome, folder.path)


def _digest(recording: MotionRecording) -> str:
    hashed = sha256()
    for stream in (recording.encoders, recording.imu, recording.tracker):
        for signal in (stream.time, stream.values) if stream else ():
            hashed.update(np.ascontiguousarray(signal).tobytes())
    return hashed.hexdigest()


def _first_of(before: Earlier[ProgramCfg], file: Path, digest: str) -> Path:
    """Recording of the first run. Raises InputError for another program, robot or measure."""
    run = before.run
    for name in ("robot", "measure", "payload"):
        if name in before.changed:
            was = getattr(before.options, name)
            raise InputError(f"{run.folder} was learned with --{name} {was}, and goes on with it")
    if run.summary["digest"] != digest:
        first = f"give {run.summary['file']}, as it was in the first run"
        raise InputError(f"{file} is not the program that {run.folder} began with: {first}")
    recording = Path(run.summary["first_recording"])
    if not recording.exists():
        raise InputError(f"{recording}, the recording of the first run, is needed and not there")
    return recording


def _refuse_corrected(file: Path) -> None:
    """A program beside the summary of the run that corrected it: its targets draw no wanted path.

    Raises InputError."""
    try:
        made = json.loads((file.parent / "summary.json").read_text(encoding="utf-8"))
        of = made["program"] if isinstance(made["program"], dict) else made
        name, offset = of.get("file" if of is not made else "program"), of["largest_offset"]
    except (OSError, ValueError, KeyError, TypeError):
        return
    if name == file.name and offset:
        own = f"learn gets your own program, and --from {file.parent} after this one was run"
        if of is not made:
            own = "learn gets one without correction, as of `armside cut --plan-only`"
        raise InputError(f"{file} is a corrected program: {own}")


ROW = ["line", "to", "targets", "least", "median", "largest", "zone", "speed", "blocks/s"]


def described(read: ProgramText) -> dict[str, Any]:
    """Entries of the summary, in SI units; spacing, zones and speeds as (min, median, max)."""
    moves = [i for i in read.program.instructions if not isinstance(i, Wait)]
    frames = {
        kind: {getattr(p, kind).name: getattr(p, kind).pose is not None for p in read.places}
        for kind in ("tool", "base")
    }
    rows = list[dict[str, Any]]()
    for row in rows_of(read):
        made = [read.program.move(i) for i in row.moves[1:]]
        speeds = np.array([move.speed.path for move in made if move.speed.path is not None])
        zones = row.zones[1:-1] if len(row.zones) > 2 else row.zones[1:]
        first, last = (read.program.lines[i] for i in (row.moves[1], row.moves[-1]))
        rows.append(
            {
                "lines": (first, last),
                "targets": len(row.targets),
                "spacing": _spread(row.spacing),
                "zones": _spread(zones),
                "speeds": _spread(speeds),
                "blocks_per_second": float((speeds / row.spacing).max()),
                "spline": bool((row.fractions[1:-1] > SPLINE).all()) and len(made) > 1,
            }
        )
    return {
        "language": read.language,
        "starts_with": read.entry,
        "moves": {
            name: sum(type(move).__name__ == name for move in moves)
            for name in ("MoveL", "MoveC", "MoveJ")
        },
        "targets": len({place.aim.point for place in read.places if place.aim is not None}),
        "linear": sum(isinstance(move, MoveL) for move in moves),
        "frames": frames,
        "rows": rows,
    }


SPLINE = 0.45
"""Zone over spacing from which a row counts as a B-spline: half of it, less rounding."""


def _spread(values: np.ndarray) -> tuple[float, float, float]:
    return float(values.min()), float(np.median(values)), float(values.max())


def _lines(found: dict[str, Any]) -> list[str]:
    moves = ", ".join(f"{n} {name}" for name, n in found["moves"].items() if n)
    start = f", starts with {found['starts_with']}" if found["starts_with"] else ""
    lines = [f"{found['language']}{start}: {moves}; {found['targets']} targets"]
    for kind, names in found["frames"].items():
        lines += [
            f"{kind} {name}" + ("" if known else ": its pose is not in the file; learning needs it")
            for name, known in names.items()
        ]
    return lines
