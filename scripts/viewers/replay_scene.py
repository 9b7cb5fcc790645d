"""From a laser run to what its replay shows: the scene, the learning curves, the text."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from armside.sim.cell import CELLS
from armside.sim.records.signals import Run
from armside.sim.replay.paths import Programmed
from armside.sim.replay.scene import Scene, write_scenes

Row = Mapping[str, Any]
DESIGN = (
    "robot",
    "pose",
    "shape",
    "speed",
    "measure",
    "law",
    "gamma",
    "delta",
    "cutoff",
    "without",
)
UNITS = {"speed": "mm/s", "delta": "samples", "cutoff": "Hz"}


def write_run(
    file: Path,
    outcome: Mapping[str, Any],
    mj: mujoco.MjModel,
    runs: Sequence[Run],
    motion: Programmed,
) -> None:
    """Write the replay of a run that has just been made.

    outcome: its summary.
    """
    write_scenes(file, [scene(outcome, mj, runs, motion)])


def scene(
    outcome: Mapping[str, Any],
    mj: mujoco.MjModel,
    runs: Sequence[Run],
    motion: Programmed,
    *,
    name: str = "",
) -> Scene:
    """What is shown of a laser run."""
    rows = outcome["iterations"]
    return Scene(
        mj=mj,
        runs=runs,
        motion=motion,
        robot=CELLS[outcome["config"]["robot"]].robot,
        name=name,
        about=about(outcome),
        learning=learning(rows) if len(rows) == len(runs) else {},
    )


def learning(rows: Sequence[Row]) -> dict[str, list[float]]:
    """Each motor's 2-norm and the tool's measures, as parts of those of the first run."""
    curves = {
        f"motor {i + 1}": [row["motor_two"][i] for row in rows]
        for i in range(len(rows[0]["motor_two"]))
    }
    curves["tool RMS"] = [row["arm_rms"] for row in rows]
    curves["tool maximum"] = [row["arm_maxdev"] for row in rows]
    return {name: _relative(values) for name, values in curves.items()}


def _relative(values: Sequence[float | None]) -> list[float]:
    """NaN where a measure is missing: a lost beam, a run that diverged."""
    numbers = np.array([np.nan if v is None else v for v in values], dtype=np.float64)
    return (numbers / numbers[0]).tolist()


def about(outcome: Mapping[str, Any]) -> str:
    """Design variables and measures as Markdown."""
    config, rows = outcome["config"], outcome["iterations"]
    design = [
        f"**{name}** {_said(config[name])} {UNITS.get(name, '')}".rstrip()
        for name in DESIGN
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
        motor = _scaled(1e3, max(row["motor_inf"]), 1)
        rms, largest = _scaled(1e6, row["arm_rms"], 0), _scaled(1e6, row["arm_maxdev"], 0)
        lines.append(f"| {row['k']} | {motor} | {rms} | {largest} |")
    if outcome["status"] != "done":
        lines += ["", f"Status: {outcome['status']}."]
    lines += [
        "",
        "Motors learn from their own angles: their error falls. The tool is what the tracker sees.",
        "Grey: programmed. Blue: where the motors alone would put the tool. Orange: the tool.",
    ]
    return "\n".join(lines)


def _said(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return ", ".join(_said(item) for item in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _scaled(factor: float, value: float | None, decimals: int) -> str:
    return "-" if value is None or not np.isfinite(value) else f"{factor * value:.{decimals}f}"
