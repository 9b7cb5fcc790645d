"""`armside program`: a robot's program in RAPID, KRL or URScript, read and described."""

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from armside.sim.controller.programs import ProgramText, read_program_file, rows_of
from armside.sim.motion.instructions import MoveL, Wait
from armside.sim.records.summary import summary

from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common, check_read

Action = Annotated[Literal["read"], Parameter(help="Describe the program of a file.")]
_FILE = ".mod (RAPID), .src with the .dat beside it (KRL), or .script (URScript)."
File = Annotated[Path, Parameter(help=_FILE, validator=check_read)]


def program(action: Action, file: File, /, *, common: Common = Common()) -> None:
    """Read a robot's program: moves, targets, spacing, zones, speeds, blocks a second.

    read: what is not understood (loops, conditions, time in place of speed) is refused with line
    and column, and nothing is skipped. See docs/programs.md.
    """
    report = Report(common)
    with checking_input():
        found = described(read_program_file(file))
    outcome = summary("program", {"action": action, "file": file}, common, **found)
    report.kept(outcome, *_lines(found))
    rows = []
    for row in found["rows"]:
        spacing, zone, speed = (row[key] for key in ("spacing", "zones", "speeds"))
        mm = [1e3 * value for value in (*spacing, zone[1], speed[1])]
        rows.append([*row["lines"], row["targets"], *mm, row["blocks_per_second"]])
    report.table("Rows of linear moves [mm], [mm/s]", ROW, rows)


ROW = ["line", "to", "targets", "spacing", "", "", "zone", "speed", "blocks/s"]


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
            f"{kind} {name}" + ("" if known else ": its pose is not in the file")
            for name, known in names.items()
        ]
    return lines
