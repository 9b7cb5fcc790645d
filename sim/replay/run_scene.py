"""Scene of a laser run, made now or stored: robot, paths, learning curves, text."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from ..motion.tool_motion import ToolMotion
from ..part.motion import PartMotion
from ..records.atomic import write_bytes
from ..records.files import InputError, reading
from ..records.signals import RecordedRun
from ..records.stored_run import StoredRun
from ..robot_file.find import find_cell
from .scene import Scene, write_scenes

Row = Mapping[str, Any]
REDRAWN = ("laser", "cut")
"""Commands whose runs hold all that a replay is drawn from."""
DESIGN = ("robot", "pose", "shape", "speed", "measure", "law", "gamma", "delta", "cutoff")
LEGEND = """\
Motors learn from their own angles: their error falls. The tracker measures the tool.
Grey: programmed. Blue: where the motors alone would put the tool. Orange: the tool."""
UNITS = {"speed": "mm/s", "delta": "samples", "cutoff": "Hz"}


def laser_scene(
    outcome: Mapping[str, Any],
    mj: mujoco.MjModel,
    runs: Sequence[RecordedRun],
    motion: ToolMotion | PartMotion,
    *,
    name: str = "",
) -> Scene:
    """Scene of a laser run with the summary `outcome`."""
    ks = {run.k for run in runs}
    kept = [row for row in outcome["iterations"] if row["k"] in ks]
    return Scene(
        mj=mj,
        runs=runs,
        motion=motion,
        robot=find_cell(outcome["config"]["robot"]).robot,
        name=name,
        about=about(outcome),
        learning=learning(kept) if len(kept) == len(runs) else {},
    )


def stored_scene(run: StoredRun, *, name: str = "") -> Scene:
    """Scene of a laser run on disk, of nothing but its files; or InputError for another one."""
    if run.experiment not in REDRAWN:
        other = f"is a run of {run.experiment}; only those of laser and cut are redrawn"
        raise InputError(f"{run.folder} {other}")
    robot, signals, path = run.robot, run.signals, run.path
    with reading(run.folder / "summary.json"):
        return laser_scene(run.summary, robot, signals.runs, path, name=name)


Stored = bytes | Sequence[Scene]
"""Replay of runs on disk: the stored one of another experiment, or scenes of laser runs."""


def read_replay(runs: Sequence[StoredRun]) -> Stored:
    """Replay of runs on disk, not yet written; several side by side under their folders' names.

    Raises InputError for runs of other experiments side by side, or a file that is missing.
    """
    if len(runs) == 1 and runs[0].experiment not in REDRAWN:
        return runs[0].file("replay.rrd").read_bytes()
    names = [run.folder.resolve().name if len(runs) > 1 else "" for run in runs]
    unique = [f"{name}-{i}" if names.count(name) > 1 else name for i, name in enumerate(names, 1)]
    return [stored_scene(run, name=name) for run, name in zip(runs, unique, strict=True)]


def write_replay(file: Path, replay: Stored, *, magnification: float | None = None) -> None:
    """Write a replay that was read, of laser runs anew."""
    if isinstance(replay, bytes):
        write_bytes(file, replay)
    else:
        write_scenes(file, replay, magnification=magnification)


def learning(rows: Sequence[Row]) -> dict[str, list[float]]:
    """Motor 2-norms and measures of the tool by iteration, relative to the first run."""
    motors = zip(*(row["motor_two"] for row in rows), strict=True)
    curves: dict[str, Sequence[float | None]] = {f"motor {i}": m for i, m in enumerate(motors, 1)}
    curves["tool RMS"] = [row["arm_rms"] for row in rows]
    curves["tool maximum"] = [row["arm_maxdev"] for row in rows]
    # None becomes NaN: a measure is missing where the beam was lost or the run diverged.
    arrays = {name: np.array(values, dtype=np.float64) for name, values in curves.items()}
    # A motor that did not move has an error of 0, which stays 0.
    return {name: (v / (v[0] if v[0] else 1.0)).tolist() for name, v in arrays.items()}


def about(outcome: Mapping[str, Any]) -> str:
    """Design variables and measures as Markdown."""
    config, rows = outcome["config"], outcome["iterations"]
    design = [
        f"**{name}** {_text(config[name])} {UNITS.get(name, '')}".rstrip()
        for name in (*DESIGN, "without")
        if config.get(name) not in (None, [], ())
    ]
    lines = [
        f"### armside {config['experiment']}",
        " · ".join([*design, f"**seed** {config['seed']}"]),
        "",
        "| k | motors, worst [mrad] | tool RMS [µm] | tool max [µm] |",
        "|---:|---:|---:|---:|",
    ]
    for row in rows:
        shown = _scaled(1e3, max(row["motor_inf"]), 1)
        tool = (_scaled(1e6, row[name], 0) for name in ("arm_rms", "arm_maxdev"))
        lines.append(f"| {row['k']} | {shown} | {' | '.join(tool)} |")
    if outcome["status"] != "done":
        lines += ["", f"Status: {outcome['status']}."]
    return "\n".join([*lines, "", LEGEND])


def _text(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return ", ".join(_text(item) for item in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _scaled(factor: float, value: float | None, decimals: int) -> str:
    return "-" if value is None or not np.isfinite(value) else f"{factor * value:.{decimals}f}"
