"""Figures beyond chapter 8 on its joint: choice of L and Q, algorithms, robustness, friction."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc import two_mass_study as study
from armside.ilc.analysis import frequency_grid, hertz, heuristic_criterion
from armside.ilc.analysis.criterion import shift_response
from armside.ilc.analysis.robustness import contraction_map, monte_carlo
from armside.ilc.filters import ALL_PASS
from armside.ilc.models.two_mass import FrictionPlant, TwoMassLoop
from armside.ilc.two_mass_study import Study
from armside.sim.evaluation.check import Table

from .canvas import INK, panels
from .design import draw_disc

LOOP = TwoMassLoop()
"""Joint and controller of the thesis."""
THESIS = Study()
"""Joint and design of the thesis."""
PLAIN = (0.125, 0.9, 0.11, 0.88)
"""Edges of a figure as matplotlib has them."""
NYQUIST_SHIFTS = (0, 2, 4, 6)
"""[samples]."""


charts = partial(panels, large=True, ruled=True)


def decibel(value: Any) -> Any:
    """20 log10 |value|."""
    return 20.0 * np.log10(np.abs(value))


def nyquist(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Learning transients: the Nyquist curve of L T_u and the unit circle at +1 (thesis 7.4)."""
    omega = frequency_grid(4000)
    T_u, f = of.loop.T_motor, hertz(omega, of.loop.sample_time)
    rows = []
    titles = "Inside the circle, a frequency is learned", "Near the origin every curve leaves it"
    labels, size = ("real part of LTᵤ", "imaginary part"), (9.0, 4.6)
    with panels(file, size, 1, 2, titles=titles, labels=labels, edges=PLAIN, large=True) as (
        whole,
        near,
    ):
        for axes in (whole, near):
            draw_disc(axes, 1.0)
            for delta in NYQUIST_SHIFTS:
                curve = shift_response(of.gamma, delta, omega) * T_u.response(omega)
                axes.plot(curve.real, curve.imag, label=f"δ = {delta}")
        whole.set(xlim=(-0.4, 2.1), ylim=(-1.1, 1.1))
        near.set(xlim=(-0.08, 0.08), ylim=(-0.08, 0.08))
        near.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for delta in NYQUIST_SHIFTS:
        result = heuristic_criterion(T_u, of.gamma, delta, ALL_PASS, omega)
        outside = np.flatnonzero(result.learning >= 1.0)
        leaves = f[outside[0]] if outside.size else None
        rows.append((delta, leaves, result.contraction))
    title = f"Nyquist view: where L T_u leaves the unit circle at +1, gamma = {of.gamma:g}"
    return Table(title, ("delta", "leaves at [Hz]", "largest |1-LTu|"), rows)


def why_q(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Phase of L T_u for shifts and for rough models: no shift allows Q = 1, most models do."""
    omega = frequency_grid(4000)
    f, T_u = hertz(omega, of.loop.sample_time), of.loop.T_motor
    phase = np.degrees(np.unwrap(np.angle(T_u.response(omega))))
    rows = []
    labels = "frequency [Hz]", "phase of LTᵤ [°]"
    titles = ("L a shift: none stays within ± 90°", "L a rough model run backwards: most do")
    with charts(file, (10.5, 4.6), 1, 2, titles=titles, labels=labels) as (left, right):
        for axes in (left, right):
            axes.axhspan(-90, 90, color="#EEF3E8")
            axes.set(xlim=(0.2, 50), xscale="log")
            axes.xaxis.set_major_formatter("{x:g}")
        for delta in (0, 1, 2, 3, 5):
            shifted = phase + np.degrees(delta * omega)
            left.plot(f, shifted, label=f"δ = {delta}")
            rows.append((f"shift, delta = {delta}", *_beyond(f, shifted)))
        for name, model in study.rough_models(of.loop).items():
            difference = np.degrees(study.phase_error(model, T_u, omega))
            right.plot(f, difference, label=name)
            rows.append((f"model backwards: {name}", *_beyond(f, difference)))
        left.text(0.25, 66, "here a small enough gain learns", color=INK, fontsize=9)
        left.set(ylim=(-270, 360), yticks=[-270, -180, -90, 0, 90, 180, 270, 360])
        right.set(ylim=(-190, 190), yticks=[-180, -90, 0, 90, 180])
        left.legend(loc="upper left")
        right.legend(loc="upper left", fontsize=8, bbox_to_anchor=(0.0, 0.98))
    title = "Why Q: where the phase of L Tu is beyond 90 degrees, with Q = 1"
    return Table(title, ("L", "first [Hz]", "last [Hz]", "largest phase [deg]"), rows)


def _beyond(f: Array, degrees: Array) -> tuple[float | str, float | str, float]:
    """First and last frequency at which an angle is beyond 90 degrees, and its largest size."""
    size = np.abs((degrees + 180.0) % 360.0 - 180.0)
    bad = np.flatnonzero(size >= 90.0)
    first, last = (float(f[bad[0]]), float(f[bad[-1]])) if bad.size else ("none", "none")
    return first, last, float(size.max())


def algorithms(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Algorithms 1 to 3 of thesis 7.5 on the same joint."""
    rows, plant = [], of.plant
    titles, labels = ["Motor error of three designs"], ("iteration k + 1", "2-norm over its first")
    with charts(file, (7.0, 4.0), titles=titles, labels=labels, legends=[0]) as (axes,):
        for name, law in study.algorithms(of).items():
            norms = study.run(plant, law, 100).motor
            axes.loglog(np.arange(1, 102), norms / norms[0], label=name)
            reached = study.iterations_to(norms, 0.05)
            rows.append((name, norms[1], norms[5], norms[100], norms[100] / norms[0], reached))
    columns = ("algorithm", "k = 1", "k = 5", "k = 100", "k = 100 / k = 0", "k at 5 %")
    return Table("Algorithms 1 to 3: 2-norm of the motor error [rad]", columns, rows)


def robustness(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Contraction over uncertain joints: a map and a Monte Carlo."""
    factors, law = np.geomspace(0.2, 5.0, 25), of.one_heuristic
    contractions = contraction_map(of.loop, law, ("Jm", factors), ("k", factors))
    rows, rng = [], np.random.default_rng(seed)
    titles = "Worst |Q(1 − LTᵤ)|; line: 1", "All parameters uncertain, 200 joints each"
    with panels(file, (10.0, 4.2), 1, 2, titles=titles, legends=[1], edges=PLAIN, large=True) as (
        left,
        right,
    ):
        mesh = left.pcolormesh(factors, factors, contractions, vmin=0.7, vmax=1.3, cmap="RdYlGn_r")
        left.contour(factors, factors, contractions, levels=[1.0], colors=INK)
        left.set(xscale="log", yscale="log")
        for axis in (left.xaxis, left.yaxis):
            axis.set_major_formatter("{x:g}")
            axis.set_ticks([0.2, 0.5, 1, 2, 5])
            axis.set_ticks([], minor=True)
        left.set(xlabel="stiffness k, times nominal", ylabel="motor inertia Jₘ, times nominal")
        left.figure.colorbar(mesh, ax=left).outline.set_visible(False)
        for spread in (0.2, 0.5, 1.0):
            sampled = monte_carlo(of.loop, law, spread, 200, rng)
            x = np.sort(sampled.contraction)
            right.plot(x, np.linspace(0, 100, len(x)), label=f"factors up to {1 + spread:g}")
            converge = 100 * sampled.fraction_converging
            rows.append((f"{1 + spread:g}", converge, x[-1], sampled.most_harmful()))
        right.axvline(1.0, color=INK, lw=1.0)
        right.set(xlabel="worst |Q(1 − LTᵤ)|", ylabel="joints at or below [%]")
    design = f"gamma = {of.gamma:g}, delta = {of.delta}, {of.cutoff:g} Hz"
    title = f"Robustness of {design} to the joint's parameters"
    columns = ("factors up to", "contract [%]", "worst contraction", "most harmful")
    return Table(title, columns, rows)


def friction(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Coulomb friction and measurement noise in the joint."""
    rows = []
    titles, labels = ("Motor side", "Arm side"), ("iteration k", "2-norm of the error [rad]")
    with charts(file, (9.6, 4.0), 1, 2, titles=titles, labels=labels, legends=[1]) as grid:
        for c, noise in ((0.0, 0.0), (0.05, 0.0), (0.2, 0.0), (0.05, 0.01)):
            rng = np.random.default_rng(seed)
            plant = FrictionPlant(loop=of.loop, coulomb=c, noise=noise, rng=rng)
            runs = study.run(plant, of.one_law, 50)
            name = f"c = {c:g} N m" + (f", noise {noise:g} rad" if noise else "")
            for axes, norms in zip(grid, (runs.motor, runs.arm), strict=True):
                axes.semilogy(norms, label=name)
            rows.append((name, *runs.motor[[0, 5, 50]], *runs.arm[[0, 5, 50]]))
    title = "Coulomb friction c and measurement noise: 2-norms [rad] at k = 0, 5, 50"
    columns = ("", "motor 0", "motor 5", "motor 50", "arm 0", "arm 5", "arm 50")
    return Table(title, columns, rows)
