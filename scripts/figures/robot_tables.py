"""Numbers of a robot and of its model as tables of the terminal and entries of a summary."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from armside.kinematics import Joint, Robot
from armside.sim.evaluation.check import Check
from armside.sim.evaluation.robot_examination import Examination

from ..shell.console import Report


def numbers(examined: Examination) -> dict[str, Any]:
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
        "axes": axes_of(examined),
        "poses": [
            {"pose": p.name, "dexterity": p.dexterity, "problem": p.problem, "nearest": p.nearest}
            for p in examined.poses
        ],
        "estimates": estimates_of(examined),
        "usual": [
            {
                "quantity": one.usual.quantity,
                "unit": one.usual.unit,
                "values": one.values,
                "range": one.range,
                "inside": one.inside,
                "source": one.usual.source,
            }
            for one in examined.usual
        ],
    }


def estimates_of(examined: Examination) -> list[dict[str, Any]]:
    """Numbers that the robot file does not give, each with its rule."""
    return [
        {"field": one.field, "values": list(one.values), "rule": one.rule}
        for one in examined.cell.estimates
    ]


def axes_of(examined: Examination) -> list[dict[str, Any]]:
    """Limits, drive and load of each axis, arm side, SI: [m], [N] and [kg] of a prismatic axis."""
    drives, limits = examined.model.drives, examined.cell.limits
    kinds = [link.joint for link in examined.cell.robot.links if link.moves]
    columns = {
        "joint": [kind.value for kind in kinds],
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


def table_of(robot: Robot) -> list[dict[str, Any]]:
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


def print_check(report: Report, found: dict[str, Any], checks: list[Check]) -> None:
    """Tables of an examination and its verdicts."""
    rows = [
        (one.site, 1e6 * one.position, 1e6 * one.rotation, _joined(np.rad2deg(one.at), ".1f"))
        for one in found["agreement"]
    ]
    drawn = f"{found['configurations']} configurations"
    title = f"D-H table against MJCF in {drawn}, every spring at zero"
    report.table(title, ("site", "largest [um]", "[urad]", "at motor angles [deg]"), rows)
    _print_axes(report, found["axes"])
    for name, words in (("locked_modes", "held"), ("free_modes", "free")):
        report.line(f"Modes [Hz], motors {words}: {_joined(found[name], '.1f')}")
    report.line(
        f"Mass {found['mass']:.1f} kg, tool up to {found['reach']:.3f} m from the base, "
        f"time step {1e3 * found['time_step']:g} ms"
    )
    print_estimates(report, found["estimates"])
    rows = [
        (
            f"{one['quantity']} [{one['unit']}]" if one["unit"] else one["quantity"],
            _joined(one["values"], ".3g"),
            "{:.2g} to {:.2g}".format(*one["range"]),
            "usual" if one["inside"] else "unusual",
            one["source"],
        )
        for one in found["usual"]
    ]
    heads = "quantity", "this robot", "usual", "", "range around"
    report.table("Plausibility, beside arms of that reach", heads, rows)
    rows = [(check.statement, check.ours, check.band, check.verdict) for check in checks]
    report.table("Verdicts", ("quantity", "value", "allowed", "verdict"), rows)


def _print_axes(report: Report, axes: list[dict[str, Any]]) -> None:
    title = (
        "Axes, arm side of the gear; speed: unit per second; load: greatest torque of gravity over "
        "the drive's limit; of a prismatic axis [mm], [N] and [kg]"
    )
    drive = "gear", "limit [N m]", "inertia [kg m^2]", "load"
    rows = []
    for one in axes:
        slides = one["joint"] == Joint.PRISMATIC.value
        unit, factor = ("mm", 1e3) if slides else ("deg", 180.0 / np.pi)
        ranges = (factor * float(one[name]) for name in ("lower", "upper", "speed"))
        others = (float(one[name]) for name in ("gear", "torque_limit", "rotor_inertia"))
        rows.append((one["axis"], *ranges, unit, *others, round(float(one["holding"]), 4)))
    report.table(title, ("axis", "from", "to", "speed", "unit", *drive), rows)


def print_estimates(report: Report, estimates: list[dict[str, Any]]) -> None:
    """Table of what is taken, nothing where the file states everything."""
    if not estimates:
        return
    rows = [(one["field"], _joined(one["values"], ".4g"), one["rule"]) for one in estimates]
    title = "Not in the robot file, SI; bodies in the axes of their joints"
    report.table(title, ("field", "taken", "rule"), rows)


def _joined(values: Iterable[float], form: str) -> str:
    return " ".join(f"{value:{form}}" for value in values)


def print_data(report: Report, name: str, found: dict[str, Any]) -> None:
    """Tables of D-H parameters, limits and drives."""
    rows = []
    for i, row in enumerate(found["table"], 1):
        theta, alpha = (float(np.rad2deg(row[angle])) for angle in ("theta", "alpha"))
        lengths = 1e3 * row["d"], 1e3 * row["a"]
        rows.append((str(i), theta, *lengths, alpha, row["joint"], row["motion"]))
    heads = "link", "theta [deg]", "d [mm]", "a [mm]", "alpha [deg]", "joint", "moved by"
    report.table(f"{name}: D-H table at zero motor angles", heads, rows)
    _print_axes(report, found["axes"])


def print_description(report: Report, robot: Robot, found: dict[str, Any]) -> None:
    """Table, zero pose, reach and singularities of a robot's kinematics."""
    title = f"{robot.name}, {robot.convention.value} Denavit-Hartenberg, phi: motor angles"
    columns = ("link", "theta [rad]", "d [m]", "a [m]", "alpha [rad]", "joint")
    pairs = enumerate(zip(found["table"], robot.links, strict=True), 1)
    report.table(title, columns, [(str(i), *row, link.joint.value) for i, (row, link) in pairs])
    report.table("Tool at phi = 0", ("x", "y", "z", "p [m]"), found["zero_pose"])
    if found["reach"] is not None:
        low, high = found["reach"]
        report.line(f"Wrist centre {low:.3f} to {high:.3f} m from axis 2, in the plane of the arm")
    for name, expression in found["singular"].items():
        report.line(f"Singular, {name}: {expression} = 0")
