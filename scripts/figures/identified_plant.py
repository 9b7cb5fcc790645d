"""Results of an identified plant: table of structures, intervals, and a figure."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis import hertz
from armside.ilc.identification.arx import Information
from armside.ilc.identification.first_order_lag import fit_of
from armside.ilc.identification.frequency_response import (
    FrequencyResponse,
    PeriodicRecord,
    frequency_response,
)
from armside.ilc.identification.polynomial_fit import PolynomialFit
from armside.ilc.identification.structures import Candidate
from armside.ilc.identification.subspace import SubspaceFit, bootstrap_response_deviation
from armside.ilc.workbench.input_output import InputOutput

from ..shell.console import Report
from .canvas import COLORS, INK, panels

SIGMAS = 1.96  # of a normal interval of 95 %
HEADS = ("structure", "orders", "BIC", "fit [%]", "white p", "input p", "validation [%]")


def periodic_response(made: InputOutput) -> FrequencyResponse | None:
    """Response with discs of 95 %, for a record whose input is periodic."""
    if made.period == 0:
        return None
    whole = len(made.u) // made.period * made.period
    record = PeriodicRecord(made.u[:whole], made.y[:whole])
    return frequency_response([[record]], made.period, made.lines)


def results(
    found: Sequence[Candidate],
    made: InputOutput,
    fresh: InputOutput | None,
    measured: FrequencyResponse | None,
) -> dict[str, Any]:
    """Entries of summary.json: the best candidate first."""
    given: dict[str, Any] = {
        "samples": len(made.u),
        "sample_time": made.sample_time,
        "structures": [
            {
                "structure": one.structure.value,
                "orders": one.orders,
                "bic": one.fit.score(Information.BIC),
                "fit": one.accuracy,
                "white_p": one.fit.whiteness and float(one.fit.whiteness.p_value.min()),
                "input_p": one.fit.independence,
                "validation": fresh and fit_of(one.system, fresh.u, fresh.y),
                "warnings": list(one.warnings),
            }
            for one in found
        ],
        "coefficients": _coefficients(found[0].fit),
        "warnings": list(found[0].warnings),
    }
    if measured is not None:
        given["frequency_response"] = {
            "frequency": hertz(measured.omega, made.sample_time).tolist(),
            "magnitude": np.abs(measured.response[:, :, 0]).T.tolist(),
            "phase": np.angle(measured.response[:, :, 0]).T.tolist(),
            "radius": measured.radius()[:, :, 0].T.tolist(),
        }
        given["warnings"] += measured.warnings
    if (p := made.y.shape[1]) != (m := made.u.shape[1]):
        given["warnings"].append(
            f"learn and design take as many outputs as inputs, not {p} and {m}"
        )
    return given


def _coefficients(fit: PolynomialFit | SubspaceFit) -> list[dict[str, Any]]:
    """Of polynomials, with intervals of 95 %; none for states, whose coordinates are arbitrary."""
    if isinstance(fit, SubspaceFit):
        return []
    sizes = zip("abcdf", fit.model.orders.sizes, strict=True)
    first = {"b": fit.model.orders.nk}
    names = [f"{name}{first.get(name, 1) + i}" for name, size in sizes for i in range(size)]
    rows = zip(names, fit.model.theta.tolist(), fit.confidence().tolist(), strict=True)
    return [{"name": name, "value": value, "interval": each} for name, value, each in rows]


def tables(report: Report, outcome: dict[str, Any]) -> None:
    """The structures, the coefficients of the best one, and what to doubt."""

    def percent(value: float | None) -> float | None:
        return None if value is None else 100.0 * value

    rows = [
        (each["structure"], each["orders"], each["bic"], percent(each["fit"]), each["white_p"],
         each["input_p"], percent(each["validation"]))
        for each in outcome["structures"]
    ]  # fmt: skip
    title = "Best order of each structure, most trustworthy first"
    report.table(title, HEADS, rows, missing="not tested, or without a validation record")
    if outcome["coefficients"]:
        rows = [(c["name"], c["value"], *c["interval"]) for c in outcome["coefficients"]]
        heads = ("coefficient of q^-i", "value", "95 % from", "to")
        report.table(f"plant.json: {outcome['structures'][0]['structure']}", heads, rows)
    for warning in outcome["warnings"]:
        report.line(f"Warning: {warning}")


def draw(
    file: Path,
    best: Candidate,
    made: InputOutput,
    measured: FrequencyResponse | None,
    fits: int,
    rng: np.random.Generator,
) -> None:
    """Response of the model with its band of 95 %, beside the measured one; output over time.

    The band of a subspace model needs `fits` repeated fits; 0 draws none.
    """
    omega = np.pi * np.geomspace(2e-3, 0.999, 300)
    f = hertz(omega, made.sample_time)
    magnitude, band = _response(best, made, omega, fits, rng)
    named = "model" if np.isnan(band).all() else "model, 95 %"
    time = made.sample_time * np.arange(len(made.y))
    look: dict[str, Any] = {"edges": (0.08, 0.98, 0.14, 0.91), "gaps": (0.18, None)}
    with panels(file, (9.6, 4.2), 1, 2, legends=[0, 1], large=True, **look) as (left, right):
        for i, (G, width) in enumerate(zip(magnitude.T, band.T, strict=True)):
            color = COLORS[i % len(COLORS)]
            left.loglog(f, G, color=color, lw=1.2, label=named if i == 0 else None)
            left.fill_between(f, np.maximum(G - width, 1e-3 * G), G + width, color=color, alpha=0.2)
        if measured is not None:
            at, size = hertz(measured.omega, made.sample_time), np.abs(measured.response[:, 0, 0])
            bars = measured.radius()[:, 0, 0]
            left.errorbar(at, size, bars, fmt=".", color=INK, ms=4, lw=0.8, label="measured, 95 %")
        left.set_xlabel("frequency [Hz]")
        left.set_title("|response|", loc="center")
        simulated = best.system.simulate(made.u)[:, 0]
        right.plot(time, made.y[:, 0], color=INK, lw=1.0, label="measured")
        right.plot(time, simulated, color=COLORS[0], lw=1.0, label="simulated")
        right.set_xlabel("time [s]")
        right.set_title("first output", loc="center")


def _response(
    best: Candidate, made: InputOutput, omega: Array, fits: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Magnitudes (M, entries), and half the widths of their intervals of 95 %."""
    G = np.abs(best.system.response(omega)).reshape(len(omega), -1)
    if isinstance(best.fit, PolynomialFit):
        return G, SIGMAS * best.fit.response_deviation(omega)[:, None]
    if fits == 0:
        return G, np.full(G.shape, np.nan)
    from scipy.special import stdtrit

    spread = bootstrap_response_deviation(best.fit, made.u, omega, rng, repeats=fits)
    return G, stdtrit(fits - 1, 0.975) * spread.reshape(len(omega), -1)
