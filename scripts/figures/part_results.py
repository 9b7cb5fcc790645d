"""Files and tables of `armside cut`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from armside.sim.evaluation.contour_error import LARGEST_RADIUS
from armside.sim.laser.experiment import Experiment, Iteration
from armside.sim.part.motion import PartMotion
from armside.sim.part.plan import Plan
from armside.sim.records.run_folder import RunFolder
from armside.sim.robot.virtual_robot import LOG_PERIOD

from ..shell.console import Report
from .laser_results import write_run

SHOWN = {
    "arm_rms": "RMS",
    "arm_maxdev": "max",
    "arm_corner": "corner",
    "arm_position": "position",
    "arm_roundness": "roundness",
    "arm_path_accuracy": "AT_p",
}
"""Measures of a contour and their columns."""
MISSING = f"roundness is that of round holes, corner of bends up to {1e3 * LARGEST_RADIUS:g} mm"


def show_plan(report: Report, plan: Plan) -> None:
    """Table of the contours in their order."""
    asked, rows = 1e3 * plan.cutting.speed, []
    for i, cut in enumerate(plan.cuts, 1):
        speeds = (1e3 * speed for speed in (cut.reached_speed, cut.lowest_allowed))
        length, contour = 1e3 * (cut.path.length - 2.0 * cut.lead), cut.contour
        named = [i, contour.name, contour.layer, contour.kind.value]
        rows.append([*named, length, *speeds, cut.seconds])
    title = f"Plan: {len(plan.cuts)} contours in {plan.seconds:.1f} s, {asked:g} mm/s asked"
    heads = [
        "",
        "contour",
        "layer",
        "kind",
        "length [mm]",
        "reached [mm/s]",
        "lowest in bends",
        "s",
    ]
    report.table(title, heads, rows)


def show_results(report: Report, outcome: dict[str, Any]) -> None:
    """Tables of contours, first and last run, and of all runs."""
    rows = []
    for i, contour in enumerate(outcome["contours"]):
        first, last = contour["iterations"][0], contour["iterations"][-1]
        cells: list[Any] = [i + 1, contour["name"], contour["kind"]]
        for name in SHOWN:
            cells += [_microns(first[name]), _microns(last[name])]
        edges = contour["kerf"][0], contour["kerf"][-1]
        rows.append([*cells, *(_microns(edge["widest_true"]) for edge in edges)])
    columns = ["", "contour", "kind"]
    for name in (*SHOWN.values(), "kerf"):
        columns += [f"{name} before", f"{name} after"]
    last = outcome["iterations"][-1]["k"]
    converged = [contour["iterations"][-1]["converged"] for contour in outcome["contours"]]
    if any(converged):
        report.line(f"Converged: {sum(converged)} of {len(converged)} contours, by k = {last}")
    title = f"Tool by the tracker before learning and at k = {last} [µm]"
    report.table(title, columns, rows, missing=MISSING)
    rows = []
    for row in outcome["iterations"]:
        motors = (None if value is None else 1e3 * value for value in row["motor_inf"])
        tool = (_microns(row[name]) for name in ("arm_rms", "arm_maxdev", "arm_position"))
        rows.append([row["k"], *motors, *tool])
    heads = ["k", *(f"motor {i}" for i in range(1, len(rows[0]) - 3)), "RMS", "max", "position"]
    title = "All contours: largest motor error [mrad of the motor shaft], tool [µm]"
    report.table(title, heads, rows)


def write_results(
    folder: RunFolder,
    experiment: Experiment[PartMotion],
    ends: Sequence[Iteration],
    outcome: dict[str, Any],
) -> None:
    """Write the files of a run; ends: its first and last iteration."""
    from armside.sim.laser.part_cut import logged

    from .part import Mapped, part_map

    runs = [logged(iteration) for iteration in ends]
    write_run(folder, experiment, runs, outcome, 1.0 / LOG_PERIOD)
    whole = {row["k"]: row["arm_rms"] for row in outcome["iterations"]}
    mapped = [Mapped(it.k, experiment.motion, it.contours, whole[it.k]) for it in ends]
    part_map(folder / "part.png", mapped)


def write_plan(folder: RunFolder, plan: Plan) -> Path:
    """Draw the plan into the folder of a run."""
    from .part import part_plan

    file = folder / "plan.png"
    part_plan(file, plan)
    return file


def _microns(value: float | None) -> float | None:
    return None if value is None else 1e6 * value
