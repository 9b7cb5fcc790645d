"""Results of a calibration: summary, tables, files of the calibrated robot, pictures."""

from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.kinematics import robot_toml
from armside.kinematics.calibration import Calibration, next_poses
from armside.kinematics.codegen import Language
from armside.kinematics.codegen import write as code
from armside.kinematics.codegen.robot_xml import urdf
from armside.kinematics.equations import forward_kinematics
from armside.kinematics.robot_file import Arm
from armside.sim.records.run_folder import RunFolder

from ..shell.console import Report
from .canvas import COLORS, panels

FITS = ("nominal", "geometry", "full")
LISTED = 20
"""Outliers in the summary; the number of all stands beside them."""


def results(done: Calibration) -> dict[str, Any]:
    """Entries of summary.json. SI units."""
    found, errors = done.identifiable, done.full.problem.choice.joint_errors
    fit, lengths = done.geometry, dict(done.geometry.problem.model.parameters)
    values = fit.x * fit.problem.scale
    rows = zip(fit.problem.names, values, fit.standard_deviations, strict=True)
    return {
        "held_out": {name: done.errors(name)._asdict() for name in FITS},
        "poses": {"fitted": len(done.fitted), "held_out": len(done.held_out)},
        "rank": found.chosen.rank,
        "smallest_singular_value": found.chosen.smallest,
        "weakest": found.chosen.weakest,
        "singular_values": found.chosen.values,
        "redundant": [{"name": d.name, "same_as": d.same_as} for d in found.redundant],
        "parameters": [
            {
                "name": name,
                "value": float(value),
                "standard_deviation": float(deviation),
                "unit": "m" if lengths.get(name, True) else "rad",
            }
            for name, value, deviation in rows
        ],
        "joint_errors": {"harmonics": errors.harmonics, "compliance": errors.compliance},
        "noise": fit.noise,
        "inside": float(done.inside.mean()),
        "n_outliers": len(done.outliers),
        "outliers": [outlier._asdict() for outlier in done.outliers[:LISTED]],
    }


def tables(report: Report, outcome: dict[str, Any]) -> None:
    """Held-out errors, rank and parameters on the terminal."""
    held_out = outcome["held_out"]
    rows = [[name, *(1e3 * value for value in held_out[name].values())] for name in FITS]
    counts = outcome["poses"]
    title = f"Error of {counts['held_out']} held-out poses [mm], {counts['fitted']} fitted"
    report.table(title, ["model", "mean", "95 %", "largest"], rows)
    smallest, weakest = outcome["smallest_singular_value"], ", ".join(outcome["weakest"])
    report.line(f"Rank {outcome['rank']}; smallest singular value {smallest:.2g}: {weakest}")
    redundant = "; ".join(
        f"{row['name']} (as {', '.join(row['same_as']) or 'nothing'})"
        for row in outcome["redundant"]
    )
    report.line(f"Not told apart, so not fitted: {redundant or 'none'}")
    shown = [
        [p["name"], 1e3 * p["value"], 1e3 * p["standard_deviation"], f"m{p['unit']}"]
        for p in outcome["parameters"]
    ]
    report.table("Parameters", ["name", "value", "standard deviation", "unit"], shown)
    errors = outcome["joint_errors"]
    if any(errors.values()):
        sag = "with" if errors["compliance"] else "without"
        report.line(f"Full model: harmonics up to {errors['harmonics']}, {sag} compliance")
    else:
        report.line("Full model: the geometry alone, without errors of the joints")
    report.line(
        f"{100 * outcome['inside']:.1f} % of the held-out poses lie where the full model holds; "
        "the geometry is used for the others"
    )
    if outcome["n_outliers"]:
        worst = outcome["outliers"][0]
        report.line(
            f"{outcome['n_outliers']} fitted measurements are unexplained, the worst: row "
            f"{worst['row']}, target {worst['target']}, {1e3 * worst['residual']:.3g} mm"
        )


def write(folder: RunFolder, done: Calibration, arm: Arm, number: int, seed: int) -> None:
    """Files of the calibrated robot, poses to measure next, and pictures."""
    robot = done.robot
    texts = {"calibrated.toml": robot_toml(robot, arm.limits)}
    texts["calibrated.urdf"] = urdf(robot, arm.limits)
    texts |= code(forward_kinematics.pose(robot), Language.C, "calibrated_pose")
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    full = done.full
    names = full.problem.choice.joint_errors.names(robot)
    lines = [f"{n},{v!r}" for n, v in zip(names, full.state.joint.tolist(), strict=True)]
    header = "function,coefficient [rad; rad/(N m) for sag]"
    (folder / "joint_errors.csv").write_text("\n".join([header, *lines, ""]), encoding="utf-8")
    if number:
        chosen = next_poses(done.geometry, arm.limits, number, np.random.default_rng(seed))
        motors = ",".join(f"motor_angle_{i + 1}" for i in range(robot.n_joints))
        np.savetxt(folder / "next_poses.csv", chosen, "%.6f", ",", header=motors, comments="")
    draw_residuals(folder / "residuals.png", done)
    draw_region(folder / "region.png", done)


def draw_residuals(file: Path, done: Calibration) -> None:
    """Distribution of the held-out errors, and where in the workspace they lie."""
    with panels(file, (11, 4.5), 1, 2, legends=[0]) as (left, right):
        for name in FITS:
            length = done.residuals(name)
            values = 1e3 * np.sort(length[np.isfinite(length)])
            style = "--" if name == "full" else "-"  # it may be the geometry
            left.plot(values, np.linspace(0, 100, len(values)), style, label=name)
        left.set(xlabel="held-out error [mm]", ylabel="poses [%]", title="Fraction below an error")
        left.set(xlim=(0, None), ylim=(0, 100))
        left.grid(True)
        length = 1e3 * np.nanmean(done.residuals("full"), axis=1)
        title, top = "Error of the full model", float(np.quantile(length, 0.98))
        _workspace(right, title, _places(done), length, extend="max", vmax=top)


def draw_region(file: Path, done: Calibration) -> None:
    """Region of use: standard deviation of the tool, and fitted values of each joint."""
    deviation = 1e3 * done.region.standard_deviation(done.held_out.phi)
    p, inside, title = _places(done), done.inside, "Standard deviation by the posterior"
    with panels(file, (11, 4.5), 1, 2) as (left, right):
        _workspace(left, title, p[inside], deviation[inside])
        left.plot(*p[~inside].T, "x", color=COLORS[1], label="refused", mew=1.0)
        left.legend(loc="upper right", frameon=True)
        for i, values in enumerate(done.region.values, 1):
            right.plot(values, np.full(len(values), i), "|", color=COLORS[0], alpha=0.4)
        right.set(
            xlabel="joint variable [rad]", ylabel="joint", title="Fitted values of each joint"
        )
        right.invert_yaxis()


def _workspace(
    axes: Any, title: str, p: Array, values: Array, extend: str = "neither", **look: Any
) -> None:
    """Values [mm] in colour at places (H, 2) [m] of the workspace."""
    dots = axes.scatter(*p.T, c=values, s=9, cmap="viridis", vmin=0, **look)
    label = "distance from the base axis [m]"
    axes.set(title=title, xlabel=label, ylabel="height [m]", aspect="equal")
    axes.figure.colorbar(dots, ax=axes, label=f"{title.lower()} [mm]", extend=extend)


def _places(done: Calibration) -> Array:
    """Distance from the base's axis and height of the tool at the held-out poses, (H, 2) [m]."""
    p = done.nominal.problem.model.nominal_pose(done.held_out.phi)[:, :3, 3]
    return np.column_stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]])
