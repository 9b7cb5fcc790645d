"""Response to the correction, identified and judged by the criterion. Thesis (9.11)-(9.13)."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.criterion import frequency_grid, hertz, shift_response
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.identification import first_order_lag as first_order
from armside.ilc.identification.arx import fit_arx
from armside.ilc.identification.first_order_lag import FirstOrderModel, fit_of
from armside.ilc.laws import Heuristic
from armside.ilc.models.system import System
from armside.sim.evaluation.check import Table

from ..report import Part, Read, Section
from . import bands, figures
from .bands import MOST_MOVED, SAMPLE_TIME, SPEEDS, Result, identify
from .table import STUDIES

POSES = ("p1", "p2")  # positions of estimation and of validation
DELAYS = range(3, 9)  # [samples], of the tables
LAW = Heuristic(Q=ZeroPhaseButterworth(10.0, SAMPLE_TIME), gamma=0.9, delta=3)
"""The law that the data are learned with."""
_MODEL = ("delay", "pole", "static gain", "delay and lag", "fit p1", "fit p2", "warnings")

Data = Mapping[str, Mapping[float, Result]]
"""Pose: speed [mm/s]: result."""


def identified_model(seed: int) -> Part:
    """(9.11), (9.12), Fig 9.8."""
    jobs = STUDIES["identification"].jobs(seed)

    def draw(read: Read, folder: Path) -> Section:
        data = {pose: {v: read(jobs[pose, v]) for v in SPEEDS} for pose in POSES}
        model = identify(data["p1"])
        at_40 = {pose: data[pose][40.0] for pose in POSES}
        _criterion_figure(folder / "9.8.png", model)
        cases = {}
        for pose, word in zip(POSES, ("estimation", "validation"), strict=True):
            for motor in MOST_MOVED:
                u, y = bands.learning_signals(data[pose], (motor,))
                fit = fit_of(model.system, u, y)
                simulated = 1e3 * model.system.simulate(u)[:, 0]
                name = f"motor {motor + 1}, {pose}, {word}: fit {fit:.3f}"
                cases[name] = 1e3 * y[:, 0], simulated
        figures.simulated(folder / "9.8-model.png", SAMPLE_TIME, cases)
        return Section(
            "9.8",
            "(9.11)-(9.13), Fig. 9.8: the identified response and the convergence criterion",
            "The response of the measured motor angle to the correction, identified from the fifth "
            "iteration at 30, 40 and 60 mm/s at p1, while the tool moves, and validated at p2. "
            "Left: the criterion for the thesis's model (9.12); right: for the model of our robot, "
            f"q^-{model.delay} {model.static_gain * (1 - model.pole):.4f} / (1 - {model.pole:.4f} "
            f"q^-1), whose best shift below 10 Hz is {bands.best_shift(model.system)}.",
            ["9.8.png", "9.8-model.png"],
            [
                *bands.fitted_model(data["p1"]),
                *bands.criterion_of(),
                *bands.predicted_rates(model.system, at_40, LAW, MOST_MOVED),
            ],
            _tables(data),
        )

    return Part(list(jobs.values()), draw)


def _criterion_figure(file: Path, model: FirstOrderModel) -> None:
    omega = frequency_grid(1200)
    omega = omega[hertz(omega, SAMPLE_TIME) >= 0.1]

    def learning(system: System) -> dict[str, Array]:
        left = {
            d: 1.0 - shift_response(0.9, d, omega) * system.response(omega) for d in range(1, 9)
        }
        return {f"δ = {d}": np.abs(values) for d, values in left.items()}

    filters = {f: ZeroPhaseButterworth(f, SAMPLE_TIME).response(omega) for f in (5.0, 10.0, 22.5)}
    bounds = {f"1/|Q|, {f:g} Hz": 1.0 / np.maximum(Q, 1e-9) for f, Q in filters.items()}
    models = {
        "model of the thesis, (9.12)": learning(bands.THESIS_MODEL),
        "model of our robot, motors 4 and 6 at p1": learning(model.system),
    }
    figures.criterion(file, hertz(omega, SAMPLE_TIME), models, bounds)


def _tables(data: Data) -> list[Table]:
    """Output error by delay and by motor, and ARX by delay: estimated at p1, validated at p2."""

    def row(model: FirstOrderModel, motors: tuple[int, ...]) -> list[float | str]:
        validation = fit_of(model.system, *bands.learning_signals(data["p2"], motors))
        dynamics = (model.delay, model.pole, model.static_gain, model.total_delay)
        return [*dynamics, model.fit, validation, "; ".join(model.warnings) or "-"]

    p1, p2 = (bands.learning_signals(data[pose], MOST_MOVED) for pose in POSES)
    # the pole makes up for a wrong delay, so the choice is flat
    fits = (first_order.fit_first_order(*p1, SAMPLE_TIME, delays=[delay]) for delay in DELAYS)
    by_delay = [row(fit, MOST_MOVED) for fit in fits]
    # the error of one model for all motors
    own = (row(identify(data["p1"], (motor,)), (motor,)) for motor in range(6))
    by_motor = [[name, *cells] for name, cells in zip(figures.MOTORS, own, strict=True)]
    by_arx = []  # the structure of (9.12) by least squares: prediction is not simulation
    for nk in DELAYS:
        fit = fit_arx(*p1, SAMPLE_TIME, na=1, nb=1, nk=nk)
        fits_of = (_simulated_fit(fit.system, *signals) for signals in (p1, p2))
        gains = float(-fit.model.theta[0]), fit.system.static_gain
        by_arx.append([nk, *gains, *fits_of, "; ".join(fit.warnings) or "-"])
    at, arx = "estimated at p1, validated at p2", "estimated at p1, simulated at p1 and p2"
    columns = ["delay", "pole", "static gain", "fit p1 [%]", "fit p2 [%]", "warnings"]
    return [
        Table(f"Output error by delay, motors 4 and 6: {at}", _MODEL, by_delay),
        Table("Output error, each motor on its own", ("", *_MODEL), by_motor),
        Table(f"ARX with one pole, motors 4 and 6: {arx}", columns, by_arx),
    ]


def _simulated_fit(system: System, u: Array, y: Array) -> float:
    """[%]; a model that predicts well may be unstable, and then simulates nothing."""
    if not system.is_stable:
        return -np.inf
    return 100.0 * float(first_order.fit_of_each(system, u, y).mean())
