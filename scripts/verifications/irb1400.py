"""Claims about the IMU on the IRB1400 and the causes of its prediction error."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.sim.evaluation.check import Table, all_hold
from armside.sim.imu import ImuExperiment, RestExperiment, prepare, reprocessed, run_one
from armside.sim.imu import experiment as causes
from armside.sim.imu import experiment as notes
from armside.sim.imu.vibration import lines, run_rest
from armside.sim.notes import Note, Tally
from armside.sim.robot.recording import saturation

BASE = ImuExperiment()
SEQUENTIAL = replace(BASE, motion="sequential")
UNAIDED = replace(SEQUENTIAL, torque_feedforward=False)


def table(
    title: str,
    rows: Sequence[Mapping[str, Any]],
    claims: Mapping[str, Any],
    notes: Sequence[Note] = (),
) -> Table:
    """Rows by the names of their columns, and statements with the conditions that they state."""
    verdicts = [all_hold(statement, bool(holds)) for statement, holds in claims.items()]
    return Table(title, list(rows[0]), [list(row.values()) for row in rows], verdicts, notes)


def by_axis(name: str, vector: Array, unit: str = " [m/s^2]") -> dict[str, float]:
    """Columns of a vector (3,)."""
    return {f"{name} {axis}{unit}": float(v) for axis, v in zip("xyz", vector, strict=True)}


def numbers(rows: Sequence[Mapping[str, Any]]) -> Array:
    """Columns after the first, (rows, columns - 1)."""
    return np.array([list(row.values())[1:] for row in rows])


def imu(seeds: Iterable[int]) -> Table:
    """The simultaneous and the sequential motion; each seed is another IMU and other noise."""
    moving = prepare(BASE)[0]
    sequential = [(each, one) for each in (SEQUENTIAL, UNAIDED) for one in prepare(each)]
    rows, said = [], Tally()
    for seed in seeds:
        result = run_one(BASE, moving, seed)
        again = reprocessed(result, BASE.processing.as_in_the_thesis)
        m, one_by_one = result.measures, [run_one(*one, seed) for one in sequential]
        for one in (result, *one_by_one):
            said.add(notes([one]))
        others = [one.measures for one in one_by_one]
        motors = ("arm", "wrist", "arm, no feedforward", "wrist, no feedforward")
        idle = [1e4 * float(np.nanmax(one.idle_peaks)) for one in others]
        inside, again_inside = (one.largest_in_rectangle[:2].all() for one in (result, again))
        rows.append(
            {
                "seed": seed,
                "clock error [ms]": 1e3 * m.clock_offset_error,
                **by_axis("a RMS", m.acceleration_rms),
                **by_axis("a window", m.acceleration_window_max),
                **by_axis("as thesis: a window", again.measures.acceleration_window_max),
                "rectangle / slow circle": result.fast_over_slow,
                "x, y largest in rectangle": float(inside),
                "as thesis: x, y largest in rectangle": float(again_inside),
                "omega RMS [rad/s]": float(m.angular_velocity_rms.max()),
                "tool to D-H [mm]": 1e3 * m.tool_distance,
                "loop [um]": 1e6 * max(one.loop_error for one in (m, *others)),
                **{f"idle {m} [1e-4 rad]": peak for m, peak in zip(motors, idle, strict=True)},
            }
        )
    found = numbers(rows)
    clock, a, window, thesis = found[:, 0], found[:, 1:4], found[:, 4:7], found[:, 7:10]
    ratio, inside, thesis_inside, omega, distance, loop = found[:, 10:16].T
    pushed, unaided = found[:, 16:18], found[:, 18:20].max(axis=1)
    slow = (ratio >= 3.0).all()
    both_smallest = _smallest_in_z(window) & _smallest_in_z(a)
    thesis_z = (thesis[:, 2] < thesis[:, 1]).all() and _smallest_in_z(thesis).mean() > 0.5
    claims = {
        "clock offsets are estimated with a standard deviation below 0.3 ms": clock.std() < 0.3,
        "and no error above 1 ms": (np.abs(clock) < 1.0).all(),
        "the acceleration error stays inside 0.8 m/s^2 in every 0.5 s window": (window < 0.8).all(),
        "it is smallest in z: its largest window, and its RMS": both_smallest.all(),
        "processed as in the thesis it reaches 0.15 to 0.8 m/s^2 in x and y and 0.35 in z": (
            _within(thesis[:, :2], 0.15, 0.8) and (thesis[:, 2] <= 0.35).all()
        ),
        "smaller in z than in y always, than in both in most seeds: the tilt of the mounting, "
        "which the thesis leaves in, shows in z": thesis_z,
        "it is largest in x and y within the rectangle; processed as in the thesis in nine of ten "
        "seeds": inside.all() and thesis_inside.mean() >= 0.9,
        "its RMS in the rectangle is at least three times that in the slow circle": slow,
        "angular velocity is predicted within 0.025 rad/s RMS": (omega < 0.025).all(),
        "the tool is 0.2 to 2 mm from its position by motor-angle D-H": _within(distance, 0.2, 2.0),
        "the linkage opens by less than 1 um in every run": (loop < 1.0).all(),
        "with feedforward no idle motor moves 2e-4 rad or more": (pushed < 2.0).all(),
        "without feedforward some idle motor moves 2e-4 to 10e-4 rad": _within(unaided, 2.0, 10.0),
    }
    title = "An IMU on the IRB1400: measured against predicted from motor angles"
    return table(title, rows, claims, said.notes("runs"))


def _within(values: Array, low: float, high: float) -> bool:
    return bool(((values > low) & (values < high)).all())


def _smallest_in_z(values: Array) -> np.ndarray:
    """(seeds,) bool of (seeds, 3)."""
    return values.argmin(axis=1) == 2


def imu_causes(seeds: Iterable[int]) -> Table:
    """The acceleration error with each of its causes switched on or off, mean over the seeds."""
    said = Tally()
    found = [dict(causes(BASE, seed, lambda run: said.add(notes([run])))) for seed in seeds]
    rows, total = [], {}
    for name in found[0]:
        names = ("acceleration_rms", "acceleration_window_max", "angular_velocity_rms")
        a, window, omega = (np.mean([getattr(e[name], m) for e in found], axis=0) for m in names)
        errors = by_axis("a RMS", a) | by_axis("a window", window)
        rows.append({"": name} | errors | by_axis("omega RMS", omega, " [rad/s]"))
        total[name] = float(np.linalg.norm(a))
    chosen, rigid = total["as chosen"], total["rigid robot, both"]
    mapped, third = total["mapped, then filtered"], total["both"] / 3
    claims = {
        "delays of the sensors left in raise the error": total["sensor delays left in"] > chosen,
        "filtering the predicted motion, not the joint rates, lowers it": mapped < chosen,
        "central differences lower it": total["central differences"] < chosen,
        "rigid, the robot has less than a third of the error, processed alike": rigid < third,
    }
    return table("Causes of the acceleration error", rows, claims, said.notes("runs"))


def rest(seeds: Iterable[int]) -> Table:
    """The zero pose, motors off and on; averaging the spectrum separates lines from noise."""
    rows, spectra, frequency, said = [], [], np.array([]), Tally()
    for seed in seeds:
        result = run_rest(RestExperiment(off=10.0, on=20.0), seed)
        said.add(saturation(result.run.recording))
        found = result.rest
        frequency = found.frequency
        spectra.append(found.on_spectrum)
        vibration = by_axis("off RMS", found.off_rms) | by_axis("on RMS", found.on_rms)
        rows.append({"seed": seed} | vibration | by_axis("on 99.7 %", found.on_level))
    off, on, level = np.split(numbers(rows), 3, axis=1)
    density = np.mean(spectra, axis=0)[:, 1]
    near_27 = max((h for f, h in lines(frequency, density) if 25.0 < f < 30.0), default=0.0)
    quiet, louder = _within(off, 0.009, 0.014), on[:, 1:] > 3.0 * off[:, 1:]
    line = "the averaged spectrum has a line at 25 to 30 Hz in y, at least 0.2 of the highest"
    claims = {
        "with motors off the noise is the sensor's, 0.009 to 0.014 m/s^2": quiet,
        "with motors on it is at least three times larger in y and z": louder.all(),
        "and its 99.7 % level is 0.15 to 0.45 m/s^2 there": _within(level[:, 1:], 0.15, 0.45),
        line: near_27 >= 0.2,
    }
    title = "Acceleration of the IRB1400 at rest, motors off and on"
    return table(title, rows, claims, said.notes("runs"))
