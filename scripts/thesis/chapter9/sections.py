"""Chapter 9 of the thesis, section by section: experiments, figure, caption, comparison."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.criterion import frequency_grid, hertz, shift_response
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.identification import learning_data as identification
from armside.ilc.identification.arx import ArxFit, fit_arx
from armside.ilc.identification.first_order import (
    FirstOrderModel,
    fit_first_order,
    fit_of,
    fit_of_each,
)
from armside.ilc.laws import Heuristic
from armside.ilc.measures import norms as measures
from armside.ilc.models.system import System

from ...figures.laser import circles as circle_figure
from ...jobs.store import Job, Result
from ..report import Check, Grid, Part, Section
from . import bands, figures
from .bands import AT, SAMPLE_TIME, THESIS_MODEL
from .table import POSES, STUDIES

Read = Callable[[Job], Result]
MOST_MOVED = (3, 5)
"""Motors 4 and 6, counted from 0: they move most, so a linear model describes them."""
RADIUS = 0.005  # [m], programmed, of all experiments
SPEEDS = (30.0, 40.0, 60.0)  # [mm/s], of the identification


def _study(name: str, seed: int) -> tuple[dict, Callable[[Read], dict]]:
    """The jobs of a study, and a reader of all their results by the same keys."""
    jobs = STUDIES[name].jobs(seed)
    return jobs, lambda read: {key: read(job) for key, job in jobs.items()}


def _part(name: str, seed: int, draw: Callable[[dict, Path], Section]) -> Part:
    jobs, results = _study(name, seed)
    return Part(list(jobs.values()), lambda read, folder: draw(results(read), folder))


def by_position(seed: int) -> Part:
    """Fig 9.5."""

    def draw(results: dict, folder: Path) -> Section:
        errors = np.array([results[pose]["motor_inf"][0] for pose in POSES])
        normalised = measures.normalise(errors, errors)
        figures.by_position(folder / "9.5.png", POSES, normalised)
        motor = int(normalised.max(axis=0).argmax()) + 1
        place = POSES[int(normalised.max(axis=1).argmax())]
        return Section(
            id="9.5",
            title="Fig. 9.5: nominal error by position, 50 mm/s",
            caption="Largest difference between reference and measured angle of each motor while "
            "the circle is cut without learning, in parts of the largest of all eighteen, which is "
            f"that of motor {motor} at {place}.",
            figures=["9.5.png"],
            checks=bands.nominal_by_position(results),
        )

    return _part("position", seed, draw)


def by_velocity(seed: int) -> Part:
    """Fig 9.6."""

    def draw(results: dict, folder: Path) -> Section:
        speeds = STUDIES["velocity"].over["speed"]
        by_speed = {v: {pose: results[v, pose] for pose in POSES} for v in speeds}
        errors = {
            pose: np.array([results[v, pose]["motor_inf"][0] for v in speeds]) for pose in POSES
        }
        largest = np.max([errors["p1"], errors["p2"]])
        reached = by_speed[max(speeds)]["p1"]["reached_speed"]
        figures.by_motor(
            folder / "9.6.png",
            "Largest motor error without learning, by programmed speed",
            {pose: errors[pose] / largest for pose in ("p1", "p2")},
            speeds,
            xlabel="speed [mm/s]",
            log=False,
        )
        return Section(
            id="9.6",
            title="Fig. 9.6: nominal error by velocity",
            caption="The same measure from 10 to 100 mm/s at p1 and p2. The motion planner lowers "
            f"a programmed 100 mm/s to {1e3 * float(reached):.0f} mm/s on this circle, where the "
            "acceleration it allows ends: the curves become flat. The comparisons include p3.",
            figures=["9.6.png"],
            checks=bands.nominal_by_velocity(by_speed),
        )

    return _part("velocity", seed, draw)


def repeatability(seed: int) -> Part:
    """(9.10)."""

    def draw(results: dict, folder: Path) -> Section:
        runs = [results[key] for key in sorted(results)]
        pairs = [
            bands.repeatability_per_iteration(first, second)
            for i, first in enumerate(runs)
            for second in runs[i + 1 :]
        ]
        values = np.array(pairs)
        low, middle, high = np.percentile(values, [5, 50, 95], axis=0)
        figures.panels(
            folder / "repeatability.png",
            "Difference of two identical experiments, (9.10)",
            {
                f"largest motor, {len(pairs)} pairs of {len(runs)} experiments": {
                    "95 % of pairs below": high,
                    "median pair": middle,
                    "5 % of pairs below": low,
                }
            },
            ylabel="(9.10)",
            wide=True,
        )
        spread = np.percentile(values, [0, 5, 25, 50, 75, 95, 100])
        return Section(
            id="repeatability",
            title="(9.10): repeatability, with statistics",
            caption=f"{len(runs)} experiments on the same robot with the same reference at p1, "
            "where only the noise differs, compared two by two. The thesis had two experiments and "
            "asked for more. A motor cannot be learned better than it repeats: values well "
            "below 1 say that the best error is not yet noise.",
            figures=["repeatability.png"],
            checks=bands.repeatability(runs[0], runs[1]),
            grids=[
                Grid(
                    title="All pairs and iterations, largest motor",
                    columns=["minimum", "5 %", "25 %", "median", "75 %", "95 %", "maximum"],
                    rows=[[float(value) for value in spread]],
                )
            ],
        )

    return _part("repeatability", seed, draw)


def ten_iterations(seed: int) -> Part:
    """Fig 9.7."""

    def draw(results: dict, folder: Path) -> Section:
        largest = max(results[pose]["motor_two"][0].max() for pose in POSES)
        content = {
            pose: dict(zip(figures.MOTORS, (results[pose]["motor_two"] / largest).T, strict=True))
            for pose in POSES
        }
        figures.panels(
            folder / "9.7.png",
            "Motor errors over ten iterations",
            content,
            ylabel="error (9.5), 2-norm",
            log=True,
        )
        return Section(
            id="9.7",
            title="Fig. 9.7: ten iterations, 50 mm/s",
            caption="2-norm of the motor errors when learning goes on for ten iterations. What can "
            "be learned from the motors is learned in five; then the curves wander "
            "within what they repeat. The thesis shows p1 and states the same for the others.",
            figures=["9.7.png"],
            checks=bands.stability(results),
        )

    return _part("stability", seed, draw)


def learning_signals(
    results: Mapping[float, Result], motors: tuple[int, ...]
) -> tuple[Array, Array]:
    """Learning data (9.11) of some motors, summed over velocities, shape (N, motors)."""
    return identification.learning_data(_records(results), motors)


def identify(
    results: Mapping[float, Result], motors: tuple[int, ...] = MOST_MOVED
) -> FirstOrderModel:
    """One T_u for these motors from learning data at several velocities."""
    return identification.identify(_records(results), SAMPLE_TIME, motors)


def _records(results: Mapping[float, Result]) -> list[identification.LearningRecord]:
    return [
        identification.LearningRecord(
            r["correction"][AT], r["error"][0], r["error"][AT], int(r["motion_end"])
        )
        for r in results.values()
    ]


def identified_model(seed: int) -> Part:
    """(9.11), (9.12), Fig 9.8."""
    jobs, results_of = _study("identification", seed)

    def draw(read: Read, folder: Path) -> Section:
        results = results_of(read)
        data = {pose: {v: results[pose, v] for v in SPEEDS} for pose in ("p1", "p2")}
        model = identify(data["p1"])
        law = Heuristic(Q=ZeroPhaseButterworth(10.0, SAMPLE_TIME), gamma=0.9, delta=3)
        at_40 = {pose: results[pose, 40.0] for pose in ("p1", "p2")}
        _criterion_figure(folder / "9.8.png", model)
        cases = {}
        for pose in ("p1", "p2"):
            for motor in MOST_MOVED:
                u, y = learning_signals(data[pose], (motor,))
                word = "estimation" if pose == "p1" else "validation"
                name = f"motor {motor + 1}, {pose}, {word}: fit {fit_of(model.system, u, y):.3f}"
                cases[name] = (1e3 * y[:, 0], 1e3 * model.system.simulate(u)[:, 0])
        n_samples = len(next(iter(cases.values()))[0])
        time: Array = np.arange(n_samples, dtype=np.float64) * SAMPLE_TIME
        figures.simulated(folder / "9.8-model.png", time, cases)
        return Section(
            id="9.8",
            title="(9.11)-(9.13), Fig. 9.8: the identified response and the convergence criterion",
            caption="The response of the measured motor angle to the correction, identified from "
            "the fifth iteration at 30, 40 and 60 mm/s at p1, while the tool moves, and "
            "validated at p2. Left: the "
            "criterion for the thesis's model (9.12); right: for the model of our robot, "
            f"q^-{model.delay} {model.static_gain * (1 - model.pole):.4f} / "
            f"(1 - {model.pole:.4f} q^-1), whose best shift below 10 Hz is "
            f"{bands.best_shift(model.system)}.",
            figures=["9.8.png", "9.8-model.png"],
            checks=[
                *bands.fitted_model(model),
                *bands.criterion_of(),
                *bands.predicted_rates(model.system, at_40, law, MOST_MOVED),
            ],
            grids=[_delay_table(data), _motors_table(data), _arx_table(data)],
        )

    return Part(list(jobs.values()), draw)


def _criterion_figure(file: Path, model: FirstOrderModel) -> None:
    omega = frequency_grid(1200)
    frequency = hertz(omega, SAMPLE_TIME)
    shown = frequency >= 0.1

    def learning(system: System) -> dict[str, Array]:
        response = system.response(omega)
        return {
            f"δ = {d}": np.abs(1.0 - shift_response(0.9, d, omega) * response)[shown]
            for d in range(1, 9)
        }

    bounds = {
        f"1/|Q|, {cutoff:g} Hz": 1.0
        / np.maximum(ZeroPhaseButterworth(cutoff, SAMPLE_TIME).response(omega)[shown], 1e-9)
        for cutoff in (5.0, 10.0, 22.5)
    }
    models = {
        "model of the thesis, (9.12)": learning(THESIS_MODEL),
        "model of our robot, motors 4 and 6 at p1": learning(model.system),
    }
    figures.criterion(file, frequency[shown], models, bounds)


def _delay_table(data: Mapping[str, Mapping[float, Result]]) -> Grid:
    """How flat the choice of the delay is: the pole takes over what the delay leaves."""
    u, y = learning_signals(data["p1"], MOST_MOVED)
    other = learning_signals(data["p2"], MOST_MOVED)
    fits = [fit_first_order(u, y, SAMPLE_TIME, delays=[delay]) for delay in range(3, 9)]
    return Grid(
        title="Output error by delay, motors 4 and 6: estimated at p1, validated at p2",
        columns=["delay", "pole", "static gain", "delay and lag", "fit p1", "fit p2"],
        rows=[
            [f.delay, f.pole, f.static_gain, f.total_delay, f.fit, fit_of(f.system, *other)]
            for f in fits
        ],
    )


def _motors_table(data: Mapping[str, Mapping[float, Result]]) -> Grid:
    """Output error, each motor on its own: how far one model for all would be wrong."""
    rows = []
    for motor in range(6):
        found = identify(data["p1"], (motor,))
        validation = fit_of(found.system, *learning_signals(data["p2"], (motor,)))
        rows.append(
            [
                f"motor {motor + 1}",
                found.delay,
                found.pole,
                found.static_gain,
                found.total_delay,
                found.fit,
                validation,
            ]
        )
    return Grid(
        title="Output error, each motor on its own",
        columns=["", "delay", "pole", "static gain", "delay and lag", "fit p1", "fit p2"],
        rows=rows,
    )


def _arx_table(data: Mapping[str, Mapping[float, Result]]) -> Grid:
    """The structure of (9.12) by least squares, for each delay: prediction is not simulation."""
    u, y = learning_signals(data["p1"], MOST_MOVED)
    u_2, y_2 = learning_signals(data["p2"], MOST_MOVED)
    fits: list[ArxFit] = [fit_arx(u, y, SAMPLE_TIME, na=1, nb=1, nk=nk) for nk in range(3, 9)]
    return Grid(
        title="ARX with one pole, motors 4 and 6: estimated at p1, simulated at p1 and p2",
        columns=["delay", "pole", "static gain", "fit p1 [%]", "fit p2 [%]"],
        rows=[
            [
                fit.nk,
                float(-fit.coefficients[0]),
                fit.system.static_gain,
                _simulated_fit(fit, u, y),
                _simulated_fit(fit, u_2, y_2),
            ]
            for fit in fits
        ],
    )


def _simulated_fit(fit: ArxFit, u: Array, y: Array) -> float:
    """[%]; a model that predicts well may be unstable, and then simulates nothing."""
    return (
        float((100.0 * fit_of_each(fit.system, u, y)).mean()) if fit.system.is_stable else -np.inf
    )


def positions_motor(seed: int) -> Part:
    """Fig 9.9."""

    def draw(results: dict, folder: Path) -> Section:
        curves = _normalised_motors(results, "motor_inf")
        figures.by_motor(folder / "9.9.png", "Motor errors by iteration at three positions", curves)
        own = [results[p]["motor_inf"][AT] / results[p]["motor_inf"][0] for p in POSES]
        grid = Grid(
            title="Error at k = 5 over the motor's own at k = 0",
            columns=["", *figures.MOTORS],
            rows=[[pose, *map(float, row)] for pose, row in zip(POSES, own, strict=True)],
        )
        return Section(
            id="9.9",
            title="Fig. 9.9: motor side at three positions, 40 mm/s",
            caption="Seen from the motors, learning works at every position: the thesis finds a "
            "decreasing error, with one slight exception. Which motor ends best or worst depends "
            "on the individual and is not compared.",
            figures=["9.9.png"],
            checks=bands.motor_side(results),
            grids=[grid],
        )

    return _part("operating point", seed, draw)


def circles(seed: int) -> Part:
    """Fig 9.10."""

    def draw(results: dict, folder: Path) -> Section:
        p1 = results["p1"]
        _circles(folder / "9.10.png", p1, range(AT + 1), "Tool path at p1 at every iteration")
        checks = [check for check in bands.arm_side(results) if check.id in ("b1", "b2")]
        return Section(
            id="9.10",
            title="Fig. 9.10: the circles at p1",
            caption="What the laser tracker sees at p1 in every iteration, moved to its centre, "
            "with the deviation from the programmed circle magnified. The panel of k = 0 is "
            "also the counterpart of Fig. 9.1.",
            figures=["9.10.png"],
            checks=checks,
        )

    return _part("operating point", seed, draw)


def positions_arm(seed: int) -> Part:
    """Fig 9.11."""

    def draw(results: dict, folder: Path) -> Section:
        named = {pose: results[pose] for pose in POSES}
        _arm_figure(folder / "9.11.png", "Tool error by iteration at three positions", named)
        rows = [
            [pose, name, *(1e6 * float(value) for value in results[pose][key])]
            for pose in POSES
            for name, key in (("RMS", "arm_rms"), ("maximum", "arm_maxdev"))
        ]
        return Section(
            id="9.11",
            title="Fig. 9.11: arm side at three positions",
            caption="The same experiments as Fig. 9.9, judged by the tool. In the thesis it "
            "improves where the arm is near, and not where it reaches out. In our robot the reason "
            "can be looked up: learning holds the motors still, so the servo no longer damps the "
            "structure behind them, whose resonances lie inside the band that is learned.",
            figures=["9.11.png"],
            checks=bands.arm_side(results),
            grids=[
                Grid(
                    title="Deviation of the tool [µm]",
                    columns=["", "", *(f"k = {k}" for k in range(AT + 1))],
                    rows=rows,
                )
            ],
        )

    return _part("operating point", seed, draw)


def shifts_motor(seed: int) -> Part:
    """Fig 9.12."""

    def draw(results: dict, folder: Path) -> Section:
        named = {f"δ = {delta}": result for delta, result in results.items()}
        figures.by_motor(
            folder / "9.12.png",
            "Motor errors for time shifts of 1 to 8 samples, p1, 50 mm/s",
            _normalised_motors(named, "motor_inf"),
            ordered=True,
        )
        last = {delta: result["motor_inf"][AT] for delta, result in results.items()}
        first = np.max([result["motor_inf"][0].max() for result in results.values()])
        return Section(
            id="9.12",
            title="Fig. 9.12: the time shift, motor side",
            caption="Motor errors for shifts from 1 to 8 samples. The thesis finds the differences "
            "rather small. Motors 4 and 6, whose response the criterion describes, learn fastest "
            "with a shift near their delay and end alike; the slower motors 3 and 5 profit from "
            "any further sample.",
            figures=["9.12.png"],
            grids=[
                Grid(
                    title="Error at k = 5, (9.5)",
                    columns=["δ", *figures.MOTORS],
                    rows=[[delta, *map(float, row / first)] for delta, row in last.items()],
                )
            ],
        )

    return _part("shift", seed, draw)


def shifts_arm(seed: int) -> Part:
    """Fig 9.13."""

    def draw(results: dict, folder: Path) -> Section:
        named = {f"{pose}, δ = {delta}": results[pose, delta] for pose, delta in results}
        _arm_figure(folder / "9.13.png", "Tool error for two time shifts", named)
        by_shift = [{pose: results[pose, delta] for pose in ("p1", "p2")} for delta in (3, 6)]
        return Section(
            id="9.13",
            title="Fig. 9.13: the time shift, arm side",
            caption="A shift of 6 samples instead of 3 leaves the correction less energy near the "
            "resonances, and the tool a smaller error.",
            figures=["9.13.png"],
            checks=bands.shift_arm(*by_shift),
        )

    return _part("shift, arm", seed, draw)


def cutoffs_motor(seed: int) -> Part:
    """Fig 9.14."""

    def draw(results: dict, folder: Path) -> Section:
        named = {f"{cutoff:g} Hz": results["p1", cutoff] for cutoff in (10.0, 15.0)}
        figures.by_motor(
            folder / "9.14.png",
            "Motor errors for two cutoff frequencies, p1",
            _normalised_motors(named, "motor_inf"),
        )
        return Section(
            id="9.14",
            title="Fig. 9.14: the cutoff, motor side",
            caption="With a cutoff of 15 Hz instead of 10 Hz more of the error is learned from. "
            "Some motors end far lower, others hardly; the comparison is in the 2-norm, that of "
            "the criterion.",
            figures=["9.14.png"],
            checks=bands.cutoff_motor(results["p1", 10.0], results["p1", 15.0]),
        )

    return _part("cutoff", seed, draw)


def cutoffs_spread(seed: int) -> Part:
    """Fig 9.15."""

    def draw(results: dict, folder: Path) -> Section:
        motor = 3
        largest = max(result["motor_inf"][0][motor] for result in results.values())
        curves = {
            f"{cutoff:g} Hz": result["motor_inf"][:, motor] / largest
            for cutoff, result in results.items()
        }
        figures.panels(
            folder / "9.15.png",
            "Motor 4 for cutoff frequencies from 5 to 22.5 Hz, p1, 50 mm/s",
            {"": curves},
            ylabel="error (9.5), ∞-norm",
            log=True,
            ordered=True,
            wide=True,
        )
        first, last = (float(curves[name][AT]) for name in ("5 Hz", "22.5 Hz"))
        return Section(
            id="9.15",
            title="Fig. 9.15: the cutoff in small steps, motor 4",
            caption="The higher the cutoff, the lower the error of motor 4 after a few iterations; "
            "at the highest ones it no longer falls in every iteration.",
            figures=["9.15.png"],
            checks=[
                Check(
                    id="c6",
                    statement="motor 4 at k = 5: 22.5 Hz over 5 Hz",
                    thesis="better with a higher cutoff",
                    ours=last / first,
                    high=1.0,
                )
            ],
        )

    return _part("cutoff, spread", seed, draw)


def cutoffs_arm(seed: int) -> Part:
    """Fig 9.16."""

    def draw(results: dict, folder: Path) -> Section:
        named = {f"{cutoff:g} Hz": results["p1", cutoff] for cutoff in (10.0, 15.0)}
        _arm_figure(folder / "9.16.png", "Tool error for two cutoff frequencies, p1", named)
        return Section(
            id="9.16",
            title="Fig. 9.16: the cutoff, arm side",
            caption="The same experiments judged by the tool: what a cutoff of 15 Hz adds to the "
            "correction lies at the resonances of the arm.",
            figures=["9.16.png"],
            checks=bands.cutoff_arm(results["p1", 10.0], results["p1", 15.0]),
        )

    return _part("cutoff", seed, draw)


def cutoffs_circles(seed: int) -> Part:
    """Fig 9.17."""

    def draw(results: dict, folder: Path) -> Section:
        fast = results["p1", 15.0]
        _circles(folder / "9.17.png", fast, (0, AT), "Tool path at p1 with a cutoff of 15 Hz")
        check = bands.cutoff_arm(results["p1", 10.0], fast)[2]
        return Section(
            id="9.17",
            title="Fig. 9.17: the circle with a cutoff of 15 Hz",
            caption="Before learning and after five iterations at 15 Hz: the slow deviation is "
            "gone and an oscillation has come.",
            figures=["9.17.png"],
            checks=[check],
        )

    return _part("cutoff", seed, draw)


def _normalised_motors(results: Mapping[str, Result], name: str) -> dict[str, Array]:
    """(9.5) of several experiments: over the largest without learning of all of them."""
    largest = max(result[name][0].max() for result in results.values())
    return {label: result[name] / largest for label, result in results.items()}


def _arm_figure(file: Path, title: str, results: Mapping[str, Result]) -> None:
    """(9.8) and (9.9) side by side."""
    content = {}
    for heading, name in (("RMS, (9.8)", "arm_rms"), ("Maximum deviation, (9.9)", "arm_maxdev")):
        largest = max(result[name][0] for result in results.values())
        content[heading] = {label: result[name] / largest for label, result in results.items()}
    figures.panels(file, title, content, ylabel="over the largest at k = 0", columns=2, wide=True)


def _circles(file: Path, result: Result, shown: range | tuple[int, ...], title: str) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    circle_figure(
        file,
        RADIUS * np.column_stack([np.cos(turn), np.sin(turn)]),
        [result["path"][k].astype(np.float64) for k in shown],
        rms=[float(result["arm_rms"][k]) for k in shown],
        maxdev=[float(result["arm_maxdev"][k]) for k in shown],
        title=title,
        iterations=shown,
    )
