"""Chapter 9 of the thesis, section by section: experiments, figure, caption, comparison."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.measures import norms as measures
from armside.sim.calibration import targets
from armside.sim.calibration.targets import AT, POSES, Result
from armside.sim.evaluation.check import Table

from ...figures.laser import circles as circle_figure
from ..report import Part, Read, Section
from . import figures
from .table import STUDIES

Results = Mapping[Any, Result]
"""Results of a study by what it varies."""
RADIUS = 0.005  # [m], programmed, of all experiments


def _of_study(
    name: str,
) -> Callable[[Callable[[Results, Path], Section]], Callable[[int], Part]]:
    """Decorator: a section that is drawn from the results of one study."""

    def decorate(draw: Callable[[Results, Path], Section]) -> Callable[[int], Part]:
        def part(seed: int) -> Part:
            jobs = STUDIES[name].jobs(seed)

            def draw_results(read: Read, folder: Path) -> Section:
                return draw({key: read(job) for key, job in jobs.items()}, folder)

            return Part(list(jobs.values()), draw_results)

        return part

    return decorate


@_of_study("position")
def by_position(results: Results, folder: Path) -> Section:
    """Fig 9.5."""
    errors = np.array([results[pose]["motor_inf"][0] for pose in POSES])
    normalised = measures.normalise(errors, errors)
    figures.by_position(folder / "9.5.png", POSES, normalised)
    place, motor = np.unravel_index(normalised.argmax(), normalised.shape)
    return Section(
        "9.5",
        "Fig. 9.5: nominal error by position, 50 mm/s",
        "Largest difference between reference and measured angle of each motor while the circle is "
        "cut without learning, in parts of the largest of all eighteen, which is that of motor "
        f"{motor + 1} at {POSES[place]}.",
        ["9.5.png"],
        targets.nominal_by_position(results),
    )


@_of_study("velocity")
def by_velocity(results: Results, folder: Path) -> Section:
    """Fig 9.6."""
    speeds = STUDIES["velocity"].over["speed"]
    at = {v: {pose: results[v, pose] for pose in POSES} for v in speeds}
    errors = {p: np.array([at[v][p]["motor_inf"][0] for v in speeds]) for p in ("p1", "p2")}
    largest = np.max(list(errors.values()))
    figures.by_motor(
        folder / "9.6.png",
        "Largest motor error without learning, by programmed speed",
        {pose: error / largest for pose, error in errors.items()},
        speeds,
        xlabel="speed [mm/s]",
        log=False,
    )
    reached = 1e3 * float(at[max(speeds)]["p1"]["reached_speed"])
    return Section(
        "9.6",
        "Fig. 9.6: nominal error by velocity",
        "The same measure from 10 to 100 mm/s at p1 and p2. The motion planner lowers a programmed "
        f"100 mm/s to {reached:.0f} mm/s on this circle, where the acceleration it allows ends: "
        "the curves become flat. The comparisons include p3.",
        ["9.6.png"],
        [*targets.growth(at[10.0], at[80.0]), *targets.saturation(at[80.0], at[100.0])],
    )


@_of_study("repeatability")
def repeatability(results: Results, folder: Path) -> Section:
    """(9.10)."""
    runs = [results[key] for key in sorted(results)]
    pairs = [
        targets.repeatability_per_iteration(first, second)
        for i, first in enumerate(runs)
        for second in runs[i + 1 :]
    ]
    low, middle, high = np.percentile(pairs, [5, 50, 95], axis=0)
    curves = {"95 % of pairs below": high, "median pair": middle, "5 % of pairs below": low}
    figures.panels(
        folder / "repeatability.png",
        "Difference of two identical experiments, (9.10)",
        {f"largest motor, {len(pairs)} pairs of {len(runs)} experiments": curves},
        ylabel="(9.10)",
        wide=True,
    )
    spread = np.percentile(pairs, [0, 5, 25, 50, 75, 95, 100])
    return Section(
        "repeatability",
        "(9.10): repeatability, with statistics",
        f"{len(runs)} experiments on the same robot with the same reference at p1, where only the "
        "noise differs, compared two by two. The thesis had two experiments and asked for more. A "
        "motor cannot be learned better than it repeats: with values well below 1 the best error "
        "is not yet noise.",
        ["repeatability.png"],
        targets.repeatability(runs[0], runs[1]),
        [
            Table(
                "All pairs and iterations, largest motor",
                ["minimum", "5 %", "25 %", "median", "75 %", "95 %", "maximum"],
                [spread.tolist()],
            )
        ],
    )


@_of_study("stability")
def ten_iterations(results: Results, folder: Path) -> Section:
    """Fig 9.7."""
    content = {
        pose: dict(zip(figures.MOTORS, norm.T, strict=True))
        for pose, norm in _normalised(results, "motor_two").items()
    }
    title = "Motor errors over ten iterations"
    figures.panels(folder / "9.7.png", title, content, ylabel="error (9.5), 2-norm", log=True)
    return Section(
        "9.7",
        "Fig. 9.7: ten iterations, 50 mm/s",
        "2-norm of the motor errors when learning goes on for ten iterations. The motors reach "
        "their steady state in five; then the curves vary within their repeatability. The thesis "
        "shows p1 and states the same for the others.",
        ["9.7.png"],
        targets.stability(results),
    )


@_of_study("operating point")
def positions_motor(results: Results, folder: Path) -> Section:
    """Fig 9.9."""
    title = "Motor errors by iteration at three positions"
    figures.by_motor(folder / "9.9.png", title, _normalised(results, "motor_inf"))
    own = {pose: targets.over_first(results[pose], "motor_inf") for pose in POSES}
    return Section(
        "9.9",
        "Fig. 9.9: motor side at three positions, 40 mm/s",
        "On the motor side learning works at every position: the thesis finds a decreasing error, "
        "with one slight exception. Which motor ends best or worst depends on the individual and "
        "is not compared.",
        ["9.9.png"],
        targets.motor_side(results),
        [
            Table(
                "Error at k = 5 over the motor's own at k = 0",
                ["", *figures.MOTORS],
                [[pose, *row.tolist()] for pose, row in own.items()],
            )
        ],
    )


@_of_study("operating point")
def circles(results: Results, folder: Path) -> Section:
    """Fig 9.10."""
    title = "Tool path at p1 at every iteration"
    _circles(folder / "9.10.png", results["p1"], range(AT + 1), title)
    return Section(
        "9.10",
        "Fig. 9.10: the circles at p1",
        "The path measured by the laser tracker at p1 in every iteration, moved to its centre, "
        "with the deviation from the programmed circle magnified. The panel of k = 0 is also the "
        "counterpart of Fig. 9.1.",
        ["9.10.png"],
        [check for check in targets.arm_side(results) if check.id in ("b1", "b2")],
    )


@_of_study("operating point")
def positions_arm(results: Results, folder: Path) -> Section:
    """Fig 9.11."""
    _arm_figure(folder / "9.11.png", "Tool error by iteration at three positions", results)
    rows = [
        [pose, name, *(1e6 * results[pose][key]).tolist()]
        for pose in POSES
        for name, key in (("RMS", "arm_rms"), ("maximum", "arm_maxdev"))
    ]
    columns = ["", "", *(f"k = {k}" for k in range(AT + 1))]
    return Section(
        "9.11",
        "Fig. 9.11: arm side at three positions",
        "The same experiments as Fig. 9.9, judged by the tool. In the thesis it improves where the "
        "arm is near, and not where it reaches out. The cause in our robot: learning "
        "holds the motors still, so the servo no longer damps the structure behind them, whose "
        "resonances lie inside the learned band.",
        ["9.11.png"],
        targets.arm_side(results),
        [Table("Deviation of the tool [µm]", columns, rows)],
    )


@_of_study("shift")
def shifts_motor(results: Results, folder: Path) -> Section:
    """Fig 9.12."""
    curves = {f"δ = {delta}": errors for delta, errors in _normalised(results, "motor_inf").items()}
    title = "Motor errors for time shifts of 1 to 8 samples, p1, 50 mm/s"
    figures.by_motor(folder / "9.12.png", title, curves, ordered=True)
    rows = [
        [delta, *errors[AT].tolist()] for delta, errors in _normalised(results, "motor_inf").items()
    ]
    return Section(
        "9.12",
        "Fig. 9.12: the time shift, motor side",
        "Motor errors for shifts from 1 to 8 samples. The thesis finds the differences rather "
        "small. Motors 4 and 6, whose response the criterion describes, learn fastest with a shift "
        "near their delay and end alike; the slower motors 3 and 5 profit from any further sample.",
        ["9.12.png"],
        tables=[Table("Error at k = 5, (9.5)", ["δ", *figures.MOTORS], rows)],
    )


@_of_study("shift, arm")
def shifts_arm(results: Results, folder: Path) -> Section:
    """Fig 9.13."""
    named = {f"{pose}, δ = {delta}": result for (pose, delta), result in results.items()}
    _arm_figure(folder / "9.13.png", "Tool error for two time shifts", named)
    delta_3, delta_6 = ({p: results[p, delta] for p in ("p1", "p2")} for delta in (3, 6))
    return Section(
        "9.13",
        "Fig. 9.13: the time shift, arm side",
        "A shift of 6 samples instead of 3 leaves the correction less energy near the resonances, "
        "and the tool a smaller error.",
        ["9.13.png"],
        targets.shift_arm(delta_3, delta_6),
    )


@_of_study("cutoff")
def cutoffs_motor(results: Results, folder: Path) -> Section:
    """Fig 9.14."""
    slow_fast = _at_p1(results)
    title = "Motor errors for two cutoff frequencies, p1"
    figures.by_motor(folder / "9.14.png", title, _normalised(slow_fast, "motor_inf"))
    return Section(
        "9.14",
        "Fig. 9.14: the cutoff, motor side",
        "With a cutoff of 15 Hz instead of 10 Hz more of the error is learned from. Some motors "
        "end far lower, others hardly; the comparison is in the 2-norm, that of the criterion.",
        ["9.14.png"],
        targets.cutoff_motor(*slow_fast.values()),
    )


@_of_study("cutoff, spread")
def cutoffs_spread(results: Results, folder: Path) -> Section:
    """Fig 9.15."""
    errors = {cutoff: result["motor_inf"][:, 3] for cutoff, result in results.items()}
    largest = max(error[0] for error in errors.values())
    curves = {f"{cutoff:g} Hz": error / largest for cutoff, error in errors.items()}
    figures.panels(
        folder / "9.15.png",
        "Motor 4 for cutoff frequencies from 5 to 22.5 Hz, p1, 50 mm/s",
        {"": curves},
        ylabel="error (9.5), ∞-norm",
        log=True,
        ordered=True,
        wide=True,
    )
    return Section(
        "9.15",
        "Fig. 9.15: the cutoff in small steps, motor 4",
        "The higher the cutoff, the lower the error of motor 4 after a few iterations; at the "
        "highest ones it no longer falls in every iteration.",
        ["9.15.png"],
        targets.compare(c6=curves["22.5 Hz"][AT] / curves["5 Hz"][AT]),
    )


@_of_study("cutoff")
def cutoffs_arm(results: Results, folder: Path) -> Section:
    """Fig 9.16."""
    slow_fast = _at_p1(results)
    _arm_figure(folder / "9.16.png", "Tool error for two cutoff frequencies, p1", slow_fast)
    return Section(
        "9.16",
        "Fig. 9.16: the cutoff, arm side",
        "The same experiments judged by the tool: the part of the correction that a cutoff of "
        "15 Hz adds lies at the resonances of the arm.",
        ["9.16.png"],
        targets.cutoff_arm(*slow_fast.values()),
    )


@_of_study("cutoff")
def cutoffs_circles(results: Results, folder: Path) -> Section:
    """Fig 9.17."""
    slow, fast = _at_p1(results).values()
    _circles(folder / "9.17.png", fast, (0, AT), "Tool path at p1 with a cutoff of 15 Hz")
    return Section(
        "9.17",
        "Fig. 9.17: the circle with a cutoff of 15 Hz",
        "Before learning and after five iterations at 15 Hz: the slow deviation is gone and an "
        "oscillation has come.",
        ["9.17.png"],
        [check for check in targets.cutoff_arm(slow, fast) if check.id == "c3"],
    )


def _at_p1(results: Results) -> dict[str, Result]:
    """Results at p1 with cutoffs of 10 and 15 Hz."""
    return {f"{cutoff:g} Hz": results["p1", cutoff] for cutoff in (10.0, 15.0)}


def _normalised(results: Results, name: str) -> dict[Any, Array]:
    """(9.5), (9.8), (9.9) of several experiments: over the largest without learning of all."""
    largest = max(result[name][0].max() for result in results.values())
    return {label: result[name] / largest for label, result in results.items()}


def _arm_figure(file: Path, title: str, results: Results) -> None:
    """(9.8) and (9.9) side by side."""
    content = {
        heading: _normalised(results, name)
        for heading, name in (("RMS, (9.8)", "arm_rms"), ("Maximum deviation, (9.9)", "arm_maxdev"))
    }
    figures.panels(file, title, content, ylabel="over the largest at k = 0", columns=2, wide=True)


def _circles(file: Path, result: Result, shown: Sequence[int], title: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    circle_figure(
        file,
        RADIUS * np.column_stack([np.cos(angle), np.sin(angle)]),
        [result["path"][k].astype(np.float64) for k in shown],
        rms=[float(result["arm_rms"][k]) for k in shown],
        maxdev=[float(result["arm_maxdev"][k]) for k in shown],
        title=title,
        iterations=shown,
    )
