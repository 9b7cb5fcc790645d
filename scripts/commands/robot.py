"""`armside robot`: a robot model examined beside its D-H table, or shown."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from armside.arrays import Array
from armside.kinematics import Joint, Robot
from armside.sim.cell_file import find_cell
from armside.sim.evaluation.check import Check
from armside.sim.evaluation.robot_examination import Examination
from armside.sim.records.summary import summary
from armside.sim.robot.cell_model import cell_model
from armside.sim.robot.model import load_model

from ..shell.console import Report, keep
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common, check_read, options

Action = Annotated[Literal["check", "show"], Parameter(help="Examine a model, or show its data.")]
_MODEL = "MJCF file in place of that robot's own, or a robot file (.toml) with its own MJCF."
Model = Annotated[Path | None, Parameter(help=_MODEL, validator=check_read)]


@options
@dataclass(frozen=True, kw_only=True)
class RobotCfg:
    """The robot."""

    robot: str = "large"
    """Robot whose D-H table, limits and poses the controller has: large, irb1400, or a robot file
    (.toml)."""


def robot(
    action: Action,
    model: Model = None,
    /,
    *,
    cfg: RobotCfg = RobotCfg(),
    common: Common = Common(),
) -> None:
    """Check a robot model against its D-H table, drives and time step, or show its data.

    check: status 1 if a verdict fails. show: D-H table, limits and drives.
    """
    report, checks, named = Report(common), list[Check](), cfg.robot
    if model is not None and model.suffix == ".toml":
        named, model = str(model), None
    with checking_input():
        cell = find_cell(named)
        if action == "show":
            loaded = cell_model(cell, model)
        else:
            loaded = load_model(cell.xml if model is None else model)
    asked, examined = (
        {"action": action, "model": model, "robot": named},
        Examination(loaded, cell),
    )
    if action == "show":
        found = {"table": _table(cell.robot), "axes": _axes(examined)}
        _show(report, cell.robot.name, found)
    else:
        checks, found = examined.checks(), _numbers(examined)
        found["checks"] = [asdict(check) | {"holds": check.holds} for check in checks]
        _print(report, found, checks)
    failed = [check for check in checks if not check.holds]
    status = "failed" if failed else "done"
    outcome = summary("robot", asked, common, status=status, **found)
    keep(outcome, common)
    report.summary(outcome)
    if failed:
        raise RunFailed(_complaint(failed, len(checks), examined.first_axis))


def _complaint(failed: list[Check], n: int, axis: int | None) -> str:
    said = ", ".join(f"{check.statement} is {check.ours:.4g}" for check in failed)
    where = "" if axis is None else f"; axis {axis} is the first that moves the tool otherwise"
    return f"{len(failed)} of {n} verdicts fail: {said}{where}"


def _numbers(examined: Examination) -> dict[str, Any]:
    """Entries of the summary, SI."""
    model = examined.model
    return {
        "configurations": len(examined.configurations),
        "agreement": list(examined.agreements),
        "first_axis": examined.first_axis,
        "reach": examined.reach,
        "mass": examined.mass,
        "time_step": model.timestep,
        "locked_modes": examined.locked_modes,
        "free_modes": examined.free_modes,
        "highest_mode": examined.highest_mode,
        "axes": _axes(examined),
    }


def _axes(examined: Examination) -> list[dict[str, Any]]:
    """Limits, drive and load of each axis, arm side, SI."""
    drives, limits = examined.model.drives, examined.cell.limits
    columns = {
        "lower": limits.lower,
        "upper": limits.upper,
        "margin": examined.margins,
        "speed": limits.speed,
        "gear": drives.gear,
        "torque_limit": np.abs(drives.gear) * drives.torque_limit,
        "rotor_inertia": examined.model.mj.dof_armature[examined.model.motor],
        "holding": examined.holding,
    }
    rows = zip(*columns.values(), strict=True)
    return [{"axis": i} | dict(zip(columns, row, strict=True)) for i, row in enumerate(rows, 1)]


def _table(robot: Robot) -> list[dict[str, Any]]:
    """Denavit-Hartenberg parameters of each link, SI, at zero motor angles."""
    theta = iter(robot.joint_variables(np.zeros(robot.n_joints)))
    motion = iter(robot.coupling)
    rows = list[dict[str, Any]]()
    for link in robot.links:
        own = {name: float(getattr(link, name)) for name in ("theta", "d", "a", "alpha")}
        moved = ""
        if link.moves:
            own["theta" if link.joint is Joint.REVOLUTE else "d"] += float(next(theta))
            terms = ((factor, i) for i, factor in enumerate(next(motion), 1) if factor)
            moved = " ".join(f"{factor:+g} phi_{i}" for factor, i in terms)
        rows.append(own | {"joint": link.joint.value, "motion": moved})
    return rows


def _print(report: Report, found: dict[str, Any], checks: list[Check]) -> None:
    report.table(
        f"D-H table against MJCF in {found['configurations']} configurations, every spring at zero",
        ("site", "largest [um]", "[urad]", "at motor angles [deg]"),
        [
            (one.site, 1e6 * one.position, 1e6 * one.rotation, _degrees(one.at))
            for one in found["agreement"]
        ],
    )
    _print_axes(report, found["axes"])
    for name, words in (("locked_modes", "held"), ("free_modes", "free")):
        report.line(f"Modes [Hz], motors {words}: {' '.join(f'{f:.1f}' for f in found[name])}")
    report.line(
        f"Mass {found['mass']:.1f} kg, tool up to {found['reach']:.3f} m from the base, "
        f"time step {1e3 * found['time_step']:g} ms"
    )
    rows = [(check.statement, check.ours, check.band, check.verdict) for check in checks]
    report.table("Verdicts", ("quantity", "value", "allowed", "verdict"), rows)


def _print_axes(report: Report, axes: list[dict[str, Any]]) -> None:
    report.table(
        "Axes, arm side of the gear; load: greatest torque of gravity over the drive's limit",
        (
            "axis",
            "from [deg]",
            "to",
            "speed [deg/s]",
            "gear",
            "limit [N m]",
            "inertia [kg m^2]",
            "load",
        ),
        [
            (
                one["axis"],
                *(float(np.rad2deg(one[name])) for name in ("lower", "upper", "speed")),
                *(float(one[name]) for name in ("gear", "torque_limit", "rotor_inertia")),
                round(float(one["holding"]), 4),
            )
            for one in axes
        ],
    )


def _show(report: Report, name: str, found: dict[str, Any]) -> None:
    report.table(
        f"{name}: D-H table at zero motor angles",
        ("link", "theta [deg]", "d [mm]", "a [mm]", "alpha [deg]", "joint", "moved by"),
        [
            (
                str(i),
                *(float(np.rad2deg(row["theta"])), 1e3 * row["d"], 1e3 * row["a"]),
                *(float(np.rad2deg(row["alpha"])), row["joint"], row["motion"]),
            )
            for i, row in enumerate(found["table"], 1)
        ],
    )
    _print_axes(report, found["axes"])


def _degrees(phi: Array) -> str:
    return " ".join(f"{angle:.1f}" for angle in np.rad2deg(phi))
