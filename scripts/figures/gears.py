"""Results of `armside gears`: summary, tables, robot file with the error, pictures."""

from pathlib import Path
from typing import Any

import numpy as np

from armside.kinematics.robot_file import Arm, GearTerm, gear_toml, robot_toml
from armside.sim.gears import Coverage, GearAnalysis, coverage
from armside.sim.gears.judgement import judged_rows
from armside.sim.gears.transmission import CONFIDENCE
from armside.sim.recordings.alignment.encoder_motion import bandpass
from armside.sim.records.run_folder import RunFolder

from ..shell.console import Report
from .canvas import COLORS, INK, REFERENCE, panels

UM = 1e6


def results(done: GearAnalysis) -> dict[str, Any]:
    """Entries of summary.json. SI units."""
    terms, clocks = [] if done.found is None else done.found.terms, list[dict[str, Any]]()
    for one in done.aligned:
        clocks.append({"recording": one.name})
        if (imu := one.imu) is not None:
            clocks[-1] |= {"gyro_delay": imu.gyro_delay, "imu_rate": imu.rate}
            clocks[-1] |= {"accelerometer_delay": imu.accelerometer_delay}
        if (tracker := one.tracker) is not None:
            clocks[-1] |= {"tracker_offset": tracker.offset, "tracker_rate": tracker.rate}
            clocks[-1] |= {"nominal_rms": tracker.rms}
    return {
        "sensor": done.sensor,
        "orders": sorted({round(term.order, 2) for term in terms}),
        "joints": [_joint(done, j, own) for j, own in enumerate(coverage(done))],
        "judged": [
            {
                "recording": one.recording,
                "learned_from": one.learned_from,
                "sensor_ratio": one.sensor,
                "sham_sensor_ratio": one.sham_sensor,
                "tool": one.tool,
                "unjudged": one.unjudged,
                "sham_tool": one.sham_tool,
                "smoothed": one.smoothed,
                "bands": one.bands,
            }
            for one in done.judgements
        ],
        "clocks": clocks,
    }


def _joint(done: GearAnalysis, joint: int, seen: Coverage) -> dict[str, Any]:
    orders, explained = done.scan.orders[joint], done.scan.explained[joint]
    best, found, tool_rms, resonance = int(np.argmax(explained)), [], 0.0, None
    if done.found is not None:
        found = [term for term in done.found.terms if term.joint == joint + 1]
        errors = [done.found.tool_error(a.motion, a.target)[:, :, joint] for a in done.aligned]
        tool_rms = float(np.sqrt((np.concatenate(errors) ** 2).sum(axis=1).mean()))
        if (softness := done.found.softness) is not None and softness[joint] > 0.0:
            resonance = float(softness[joint] ** -0.5)  # [Hz], that amplifies the joint's error
    return {
        "joint": joint + 1,
        "terms": [
            {
                "order": term.order,
                "order_deviation": term.order_deviation,
                "amplitude": term.amplitude,
                "amplitude_interval": [
                    term.amplitude + sign * CONFIDENCE * term.amplitude_deviation
                    for sign in (-1.0, 1.0)
                ],
                "phase": term.phase,
                "phase_deviation": term.phase_deviation,
            }
            for term in found
        ],
        "resonance": resonance,
        "tool_rms": tool_rms,
        "usable": seen.usable,
        "smallest_amplitude": seen.smallest,
        "resolution": done.resolution[joint],
        "scan_peak": {
            "order": orders[best],
            "explained": explained[best] / done.scan.energy,
            "over_median": explained[best] / done.scan.typical[joint],
        },
    }


def tables(report: Report, outcome: dict[str, Any]) -> None:
    """Terms, and what they leave of the error, on the terminal."""
    rows = [
        [
            joint["joint"],
            term["order"],
            UM * term["amplitude"],
            UM * (term["amplitude_interval"][1] - term["amplitude"]),
            term["phase"],
            CONFIDENCE * term["phase_deviation"],
            UM * joint["tool_rms"] if k == 0 else None,
        ]
        for joint in outcome["joints"]
        for k, term in enumerate(joint["terms"])
    ]
    if not rows:
        report.line("No order stands out from chance.")
        return
    head = ["joint", "order", "µrad", "±", "phase", "±", "tool [µm]"]
    report.table("Transmission error, 95 % intervals", head, rows)
    judged = []
    for one in outcome["judged"]:
        cells = [one["recording"], one["sensor_ratio"], one["sham_sensor_ratio"], *[None] * 6]
        if (tool := one["tool"]) is not None:
            cells[3:8] = [tool["pooled"], one["sham_tool"]["pooled"], *map(float, tool["ratio"])]
            cells[8] = None if one["smoothed"] is None else one["smoothed"]["pooled"]
            cells = [round(cell, 3) if isinstance(cell, float) else cell for cell in cells]
        judged.append(cells)
    report.table(
        f"Judged on what was not learned from: RMS with over without, {outcome['sensor']}, tool",
        ["recording", "sensor", "sham", "tool", "sham", "x", "y", "z", "+ IMU"],
        judged,
    )


def bands_table(report: Report, done: GearAnalysis) -> None:
    """Fused position against the tracker in bands, on the terminal."""
    for judgement in done.judgements:
        rows = [
            [
                f"{band.band[0]:g}-{band.band[1]:g}",
                UM * band.rms,
                UM * band.floor,
                round(band.gears, 3),
                None if band.fused is None else round(band.fused, 3),
                round(band.beyond_floor(band.gears if band.fused is None else band.fused), 3),
            ]
            for band in judgement.bands
        ]
        if rows:
            report.table(
                f"{judgement.recording}: tool by the tracker, RMS with over without, all axes",
                ["Hz", "encoders [µm]", "floor [µm]", "gears", "+ IMU", "less floor"],
                rows,
            )


def write(folder: RunFolder, done: GearAnalysis, arm: Arm) -> None:
    """gears.toml and robot.toml with the transmission error, and pictures."""
    terms = [] if done.found is None else done.found.terms
    rows = [GearTerm(t.joint, t.order, t.amplitude, t.phase) for t in terms]
    text = robot_toml(arm.robot, arm.limits, rows)
    (folder / "robot.toml").write_text(text, encoding="utf-8")
    deviations = [(t.order_deviation, t.amplitude_deviation, t.phase_deviation) for t in terms]
    known = gear_toml(arm.robot, rows, deviations)
    (folder / "gears.toml").write_text(known, encoding="utf-8")
    draw_scan(folder / "scan.png", done)
    if any(one.tool is not None for one in done.judgements):
        draw_tool(folder / "tool.png", done)
        draw_fused(folder / "fused.png", done)


def draw_scan(file: Path, done: GearAnalysis) -> None:
    """Energy that each order of each joint explains, over the joint's median."""
    n = len(done.resolution)
    height, found = 1.2 + 1.25 * n, [] if done.found is None else done.found.terms
    edges = 0.11, 0.97, 0.5 / height, 0.93
    labels = "order [periods per turn of the joint]", ""
    with panels(file, (8.0, height), n, labels=labels, edges=edges, sharex=True) as grid:
        for joint, panel in enumerate(grid):
            strength = done.scan.explained[joint] / done.scan.typical[joint]
            panel.semilogy(done.scan.orders[joint], np.maximum(strength, 1e-2), lw=0.9)
            panel.axhline(1.0, color=REFERENCE, lw=0.8)
            for term in found:
                if term.joint == joint + 1:
                    panel.axvline(term.order, color=COLORS[1], lw=0.8, ls="--")
            panel.set_ylabel(f"joint {joint + 1}", color=INK)
            panel.set_ylim(0.3, 3.0 * max(10.0, float(strength.max())))
        title = "Energy explained by an order, over the median; dashed: taken"
        grid[0].figure.suptitle(title)


def draw_tool(file: Path, done: GearAnalysis) -> None:
    """Ten seconds of the tool's error in the judged band, before and after, for each axis."""
    judgement = next(one for one in done.judgements if one.tool is not None)
    one = next(each for each in done.aligned if each.name == judgement.recording)
    residual = one.tool_residual()[0]
    estimate = judgement.found.tool_error(one.motion, one.target).sum(axis=2)
    seen, left = (bandpass(x, *done.cfg.judged) for x in (residual, residual - estimate))
    first = int(np.flatnonzero(judged_rows(one))[0])
    rows = slice(first, first + 1000)
    time = one.motion.time[rows] - one.motion.time[0]
    low, high = done.cfg.judged
    look: dict[str, Any] = {"edges": (0.09, 0.98, 0.08, 0.92), "sharex": True, "large": True}
    with panels(file, (9.0, 6.0), 3, labels=("time [s]", ""), **look) as grid:
        for axis, panel in enumerate(grid):
            error, rest = UM * seen[rows, axis], UM * left[rows, axis]
            panel.plot(time, error, color=REFERENCE, lw=1.0, label="encoders alone")
            panel.plot(time, rest, color=COLORS[0], lw=1.0, label="with gear error")
            panel.set_ylabel(f"{'xyz'[axis]} [µm]")
        grid[0].legend(loc="upper right", ncols=2)
        title = f"Error of the tool at {low:g} to {high:g} Hz by the tracker, {one.name}"
        grid[0].figure.suptitle(title)


def draw_fused(file: Path, done: GearAnalysis) -> None:
    """Spectra of the tool's error: encoders, with gear error, with the IMU; the tracker's floor."""
    judged = [one for one in done.judgements if one.spectra is not None]
    height = 1.2 + 2.2 * len(judged)
    edges = 0.11, 0.97, 0.55 / height, 1.0 - 0.5 / height
    look = {"labels": ("frequency [Hz]", "[µm/√Hz]"), "edges": edges, "sharex": True}
    with panels(file, (8.0, height), len(judged), **look) as grid:
        for one, panel in zip(judged, grid, strict=True):
            assert one.spectra is not None
            for label, density, color in (
                ("encoders", one.spectra.encoders, REFERENCE),
                ("+ gear error", one.spectra.gears, COLORS[0]),
                ("+ gear error and IMU", one.spectra.fused, COLORS[1]),
            ):
                if density is not None:
                    x = one.spectra.frequency
                    panel.loglog(x, UM * density, color=color, lw=1.0, label=label)
            low, high = one.bands[0].band  # the noise is that of the tracker, all axes
            floor = UM * (one.bands[0].floor / float(np.sqrt(high - low)))
            panel.axhline(floor, color=INK, lw=0.8, ls="--", label="floor")
            panel.set(xlim=(0.5, 40.0), title=one.recording)
        grid[0].legend(ncols=2)
        grid[0].figure.suptitle("Error of the tool by the tracker, all axes")
