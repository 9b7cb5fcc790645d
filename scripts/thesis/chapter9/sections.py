"""Chapter 9 of the thesis, section by section: experiments, figure, caption, comparison."""

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures
from armside.sim.evaluation.check import Check, Table

from ...figures.laser import circles as circle_figure
from ..report import Asked, Entry, Part, Read, Section
from . import bands, figures
from .bands import AT, POSES, Result
from .designs import friction_feedforward, per_motor
from .response import identified_model
from .robots_and_speeds import effects, individuals, phenomena_map
from .table import STUDIES

Results = Mapping[Any, Result]
"""Results of a study by what it varies."""
ENTRIES: list[Entry] = []
"""Sections in the order of the report."""
RADIUS = 0.005  # [m], programmed, of all experiments


class Drawn(NamedTuple):
    """Content of a section whose figure is drawn."""

    caption: str
    checks: Sequence[Check] = ()
    tables: Sequence[Table] = ()


Draw = Callable[[Results, Path], Drawn]
"""Draws the figure of a section into a file."""


def _section(id: str, study: str, title: str, *also: str) -> Callable[[Draw], Draw]:
    """Decorator: adds a section with one figure, from the results of one study."""

    def added(draw: Draw) -> Draw:
        def make(asked: Asked) -> Part:
            jobs = STUDIES[study].jobs(asked.seed)

            def section(read: Read, folder: Path) -> Section:
                results = {key: read(job) for key, job in jobs.items()}
                caption, checks, tables = draw(results, folder / f"{id}.png")
                return Section(id, title, caption, [f"{id}.png"], checks, tables)

            return Part(list(jobs.values()), section)

        ENTRIES.append(Entry(id, make, also))
        return draw

    return added


def _add(id: str, make: Callable[[int], Part], *also: str, alone: bool = False) -> None:
    """Add a section that is more than one figure of one study."""
    ENTRIES.append(Entry(id, lambda asked: make(asked.seed), also, alone))


@_section("9.5", "position", "Fig. 9.5: nominal error by position, 50 mm/s", "X04")
def by_position(results: Results, file: Path) -> Drawn:
    errors = np.array([results[pose]["motor_inf"][0] for pose in POSES])
    normalised = measures.normalise(errors, errors)
    figures.by_position(file, POSES, normalised)
    place, motor = np.unravel_index(normalised.argmax(), normalised.shape)
    return Drawn(
        "Largest difference between reference and measured angle of each motor while the circle is "
        "cut without learning, in parts of the largest of all eighteen, which is that of motor "
        f"{motor + 1} at {POSES[place]}.",
        bands.nominal_by_position(results),
    )


@_section("9.6", "velocity", "Fig. 9.6: nominal error by velocity", "X04")
def by_velocity(results: Results, file: Path) -> Drawn:
    speeds = STUDIES["velocity"].over["speed"]
    at = {v: {pose: results[v, pose] for pose in POSES} for v in speeds}
    errors = {p: np.array([at[v][p]["motor_inf"][0] for v in speeds]) for p in ("p1", "p2")}
    largest = np.max(list(errors.values()))
    curves = {pose: error / largest for pose, error in errors.items()}
    title = "Largest motor error without learning, by programmed speed"
    figures.by_motor(file, title, curves, speeds, xlabel="speed [mm/s]", log=False)
    reached = 1e3 * float(at[max(speeds)]["p1"]["reached_speed"])
    return Drawn(
        "The same measure from 10 to 100 mm/s at p1 and p2. The motion planner lowers a programmed "
        f"100 mm/s to {reached:.0f} mm/s on this circle, where the acceleration it allows ends: "
        "the curves become flat. The comparisons include p3.",
        [*bands.growth(at[10.0], at[80.0]), *bands.saturation(at[80.0], at[100.0])],
    )


@_section("repeatability", "repeatability", "(9.10): repeatability, with statistics", "X05", "9.10")
def repeatability(results: Results, file: Path) -> Drawn:
    runs = [results[key] for key in sorted(results)]
    pairs = [bands.repeatability_per_iteration(*pair) for pair in combinations(runs, 2)]
    low, middle, high = np.percentile(pairs, [5, 50, 95], axis=0)
    curves = {"95 % of pairs below": high, "median pair": middle, "5 % of pairs below": low}
    title = "Difference of two identical experiments, (9.10)"
    panel = f"largest motor, {len(pairs)} pairs of {len(runs)} experiments"
    figures.panels(file, title, {panel: curves}, ylabel="(9.10)", wide=True)
    spread = np.percentile(pairs, [0, 5, 25, 50, 75, 95, 100])
    columns = ["minimum", "5 %", "25 %", "median", "75 %", "95 %", "maximum"]
    return Drawn(
        f"{len(runs)} experiments on the same robot with the same reference at p1, where only the "
        "noise differs, compared two by two. The thesis had two experiments and asked for more. A "
        "motor cannot be learned better than it repeats: with values well below 1 the best error "
        "is not yet noise.",
        bands.repeatability(runs[0], runs[1]),
        [Table("All pairs and iterations, largest motor", columns, [spread.tolist()])],
    )


@_section("9.7", "stability", "Fig. 9.7: ten iterations, 50 mm/s", "X06")
def ten_iterations(results: Results, file: Path) -> Drawn:
    norms = _normalised(results, "motor_two")
    content = {p: dict(zip(figures.MOTORS, norm.T, strict=True)) for p, norm in norms.items()}
    title = "Motor errors over ten iterations"
    figures.panels(file, title, content, ylabel="error (9.5), 2-norm", log=True)
    return Drawn(
        "2-norm of the motor errors when learning goes on for ten iterations. Nearly all "
        "of the fall takes five. The thesis sees no significant change after them; here some "
        "fall on. It shows p1 and states the same for the others.",
        bands.stability(results),
    )


_add("9.8", identified_model, "X07", "9.12", "9.13")


@_section("9.9", "operating point", "Fig. 9.9: motor side at three positions, 40 mm/s", "X08")
def positions_motor(results: Results, file: Path) -> Drawn:
    title = "Motor errors by iteration at three positions"
    figures.by_motor(file, title, _normalised(results, "motor_inf"))
    own = [[pose, *bands.over_first(results[pose], "motor_inf").tolist()] for pose in POSES]
    title = "Error at k = 5 over the motor's own at k = 0"
    return Drawn(
        "On the motor side learning works at every position: the thesis finds a decreasing error, "
        "with one slight exception. Which motor ends best or worst depends on the individual and "
        "is not compared.",
        bands.motor_side(results),
        [Table(title, ["", *figures.MOTORS], own)],
    )


@_section("9.10", "operating point", "Fig. 9.10: the circles at p1", "X08", "9.1")
def circles(results: Results, file: Path) -> Drawn:
    _circles(file, results["p1"], range(AT + 1), "Tool path at p1 at every iteration")
    return Drawn(
        "The path measured by the laser tracker at p1 in every iteration, moved to its centre, "
        "with the deviation from the programmed circle magnified. The panel of k = 0 is also the "
        "counterpart of Fig. 9.1.",
        [check for check in bands.arm_side(results) if check.id in ("b1", "b2")],
    )


@_section("9.11", "operating point", "Fig. 9.11: arm side at three positions", "X08")
def positions_arm(results: Results, file: Path) -> Drawn:
    _arm_figure(file, "Tool error by iteration at three positions", results)
    shown = product(POSES, (("RMS", "arm_rms"), ("maximum", "arm_maxdev")))
    rows = [[pose, name, *(1e6 * results[pose][key]).tolist()] for pose, (name, key) in shown]
    columns = ["", "", *(f"k = {k}" for k in range(AT + 1))]
    rms = results["p2"]["arm_rms"]
    rise = [f"{k}" for k in range(2, AT + 1) if rms[k] > rms[k - 1]]
    return Drawn(
        "The same experiments as Fig. 9.9, judged by the tool. In the thesis it improves where the "
        "arm is near, and not where it reaches out; at p2 the error has an increasing trend. Here "
        f"the RMS at p2 falls in the first update, rises at k = {', '.join(rise) or 'none'} and "
        "falls in all others. At p3 the verdict is that of k = 5: with 40 updates the RMS of seed "
        "0 is below that of k = 0 from k = 10 on (armside laser --pose p3 --iterations 40). The "
        "cause in our robot: learning holds the motors still, so the servo no longer damps the "
        "structure behind them, whose resonances lie inside the learned band.",
        bands.arm_side(results),
        [Table("Deviation of the tool [µm]", columns, rows)],
    )


@_section("9.12", "shift", "Fig. 9.12: the time shift, motor side", "X09")
def shifts_motor(results: Results, file: Path) -> Drawn:
    errors = _normalised(results, "motor_inf")
    content = {
        f"k = {k}": {m: [e[k, i] for e in errors.values()] for i, m in enumerate(figures.MOTORS)}
        for k in (1, AT)
    }
    title = "Motor errors over the time shift, after one update and five, p1, 50 mm/s"
    look: dict[str, Any] = {"xlabel": "time shift δ [samples]", "ylabel": "error (9.5), ∞-norm"}
    figures.panels(file, title, content, list(errors), **look, log=True, columns=2, wide=True)
    rows = [[delta, *error[AT].tolist()] for delta, error in errors.items()]
    return Drawn(
        "Motor errors for shifts from 1 to 8 samples. The thesis finds the differences rather "
        "small. Motors 4 and 6, whose response the criterion describes, learn fastest with a shift "
        "near their delay and end alike; the slower motors 3 and 5 profit from any further sample.",
        bands.shift_motor(results),
        [Table("Error at k = 5, (9.5)", ["δ", *figures.MOTORS], rows)],
    )


@_section("9.13", "shift, arm", "Fig. 9.13: the time shift, arm side", "X09")
def shifts_arm(results: Results, file: Path) -> Drawn:
    named = {f"{pose}, δ = {delta}": result for (pose, delta), result in results.items()}
    _arm_figure(file, "Tool error for two time shifts", named, paired=True)
    delta_3, delta_6 = ({p: results[p, delta] for p in ("p1", "p2")} for delta in (3, 6))
    return Drawn(
        "A shift of 6 samples instead of 3 leaves the correction less energy near the resonances, "
        "and the tool a smaller error.",
        bands.shift_arm(delta_3, delta_6),
    )


@_section("9.14", "cutoff", "Fig. 9.14: the cutoff, motor side", "X10")
def cutoffs_motor(results: Results, file: Path) -> Drawn:
    slow_fast = _at_p1(results)
    title = "Motor errors for two cutoff frequencies, p1"
    figures.by_motor(file, title, _normalised(slow_fast, "motor_inf"))
    return Drawn(
        "With a cutoff of 15 Hz instead of 10 Hz more of the error is learned from. In the "
        "infinity norm, that of the thesis's figure, some motors end far lower and the others "
        "higher, where the thesis has none higher.",
        [*bands.cutoff_worse(*slow_fast.values()), *bands.cutoff_motor(*slow_fast.values())],
    )


@_section("9.15", "cutoff, spread", "Fig. 9.15: the cutoff in small steps, motor 4", "X10")
def cutoffs_spread(results: Results, file: Path) -> Drawn:
    errors = {cutoff: result["motor_inf"][:, 3] for cutoff, result in results.items()}
    largest = max(error[0] for error in errors.values())
    curves = {f"{cutoff:g} Hz": error / largest for cutoff, error in errors.items()}
    title = "Motor 4 for cutoff frequencies from 5 to 22.5 Hz, p1, 50 mm/s"
    look: dict[str, Any] = {"log": True, "ordered": True, "wide": True}
    figures.panels(file, title, {"": curves}, ylabel="error (9.5), ∞-norm", **look)
    return Drawn(
        "The higher the cutoff, the lower the error of motor 4 after a few iterations; at the "
        "highest ones it no longer falls in every iteration.",
        bands.compare(c6=curves["22.5 Hz"][AT] / curves["5 Hz"][AT]),
    )


@_section("9.16", "cutoff", "Fig. 9.16: the cutoff, arm side", "X10")
def cutoffs_arm(results: Results, file: Path) -> Drawn:
    slow_fast = _at_p1(results)
    _arm_figure(file, "Tool error for two cutoff frequencies, p1", slow_fast)
    return Drawn(
        "The same experiments judged by the tool: the part of the correction that a cutoff of "
        "15 Hz adds lies at the resonances of the arm.",
        bands.cutoff_arm(*slow_fast.values()),
    )


@_section("9.17", "cutoff", "Fig. 9.17: the circle with a cutoff of 15 Hz", "X10")
def cutoffs_circles(results: Results, file: Path) -> Drawn:
    slow, fast = _at_p1(results).values()
    _circles(file, fast, (0, AT), "Tool path at p1 with a cutoff of 15 Hz")
    return Drawn(
        "Before learning and after five iterations at 15 Hz: the slow deviation is gone and an "
        "oscillation has come.",
        [check for check in bands.cutoff_arm(slow, fast) if check.id == "c3"],
    )


def _at_p1(results: Results) -> dict[str, Result]:
    """Results at p1 with cutoffs of 10 and 15 Hz."""
    return {f"{cutoff:g} Hz": results["p1", cutoff] for cutoff in (10.0, 15.0)}


def _normalised(results: Results, name: str) -> dict[Any, Array]:
    """(9.5), (9.8), (9.9) of several experiments: over the largest without learning of all."""
    largest = max(result[name][0].max() for result in results.values())
    return {label: result[name] / largest for label, result in results.items()}


def _arm_figure(file: Path, title: str, results: Results, *, paired: bool = False) -> None:
    """(9.8) and (9.9) side by side."""
    headings = {"RMS, (9.8)": "arm_rms", "Maximum deviation, (9.9)": "arm_maxdev"}
    content = {heading: _normalised(results, name) for heading, name in headings.items()}
    look: dict[str, Any] = {"columns": 2, "wide": True, "paired": paired}
    figures.panels(file, title, content, ylabel="over the largest at k = 0", **look)


def _circles(file: Path, result: Result, shown: Sequence[int], title: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    programmed = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    paths = [result["path"][k].astype(np.float64) for k in shown]
    rms, maxdev = ([float(result[name][k]) for k in shown] for name in ("arm_rms", "arm_maxdev"))
    names = [f"k = {k}" for k in shown]
    circle_figure(file, programmed, paths, rms=rms, maxdev=maxdev, title=title, names=names)


_add("F08", per_motor)
_add("F09", friction_feedforward)
_add("F07", individuals, alone=True)
_add("9-map", phenomena_map, alone=True)
_add("9-effects", effects, alone=True)
