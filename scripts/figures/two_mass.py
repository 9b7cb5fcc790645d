"""Every figure of chapter 8, and four more: each draws one PNG and returns its table."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from armside.arrays import Array
from armside.ilc import chapter8
from armside.ilc.analysis import (
    frequency_grid,
    hertz,
    heuristic_criterion,
    largest_cutoff,
    largest_gamma,
)
from armside.ilc.analysis.criterion import shift_response
from armside.ilc.analysis.robustness import Design, contraction_map, monte_carlo
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.models.system import unit_circle
from armside.ilc.models.two_mass import TwoMassLoop
from armside.ilc.models.two_mass_friction import FrictionPlant
from armside.sim.evaluation.check import Table

from .laser import COLORS, INK, REFERENCE, new_figure, save

LOOP = TwoMassLoop()
T_S = LOOP.sample_time
SHOWN = (0, 1, 2, 5)
"""Iterations of the time signals."""
COUNTED = (0, 1, 2, 3, 5, 10, 25, 100, 500)
"""Iterations in the tables."""
THESIS_SHIFT = {"motor": 5, "arm": 15}
"""The best shift of each side, as the thesis has it in 8.4.2."""
AT_THESIS_SHIFT = "gamma, delta 5 (arm 15)"
AS_STATED, ONE_LESS = "Q = 1, δ = 5 (as stated)", "Q = 1, δ = 4 (fits the figure)"


def bode(file: Path, seed: int) -> Table:
    """Fig 8.3: the motor's notch coincides with the arm's peak."""
    G_m, G_a = LOOP.joint.motor(T_S), LOOP.joint.arm(T_S)
    omega = np.geomspace(2e-3, np.pi * 0.999, 4000)
    f = hertz(omega, T_S)
    responses = {"$G_m$": G_m.response(omega), "$G_a$": G_a.response(omega)}
    responses["$G_a G_m$"] = responses["$G_m$"] * responses["$G_a$"]
    figure = new_figure(7.0, 5.6)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for (name, response), color in zip(responses.items(), COLORS, strict=False):
        upper.semilogx(f, _decibel(response), color=color, label=name)
        lower.semilogx(f, np.degrees(np.unwrap(np.angle(response))), color=color)
    upper.set_title("Voltage to motor, motor to arm, voltage to arm", loc="left")
    upper.set_ylabel("magnitude [dB]")
    upper.set_ylim(-90, 10)
    lower.set_ylabel("phase [°]")
    upper.legend(frameon=False)
    _finish(file, figure, [upper, lower], "frequency [Hz]", only_last=True)
    arm, motor = _decibel(responses["$G_a$"]), _decibel(responses["$G_m$"])
    near = (f > 0.5) & (f < 1.4)
    notch, peak = np.flatnonzero(near)[motor[near].argmin()], arm.argmax()
    return Table(
        title="Fig 8.3: discrete joint",
        columns=("", "frequency [Hz]", "magnitude [dB]"),
        rows=[
            ("peak of the arm, G_a", f[peak], arm[peak]),
            ("notch of the motor, G_m", f[notch], motor[notch]),
            ("zeros of G_m(s) = poles of G_a(s)", _resonance(), ""),
        ],
    )


def reference(file: Path, seed: int) -> Table:
    """Fig 8.4: the arm reference and its speed."""
    r_a = chapter8.learned(17.0).plant.arm_reference[:, 0]
    speed = np.diff(r_a, prepend=0.0) / T_S
    t = np.arange(len(r_a)) * T_S
    figure = new_figure(7.0, 3.6)
    axes = figure.subplots()
    axes.plot(t, r_a, color=COLORS[0], label="$r_a$ [rad]")
    axes.plot(t, speed, color=COLORS[1], label="its speed [rad/s]")
    axes.set_xlim(0.5, 2.5)
    axes.set_title("Arm reference", loc="left")
    axes.legend(frameon=False)
    _finish(file, figure, [axes], "time [s]")
    moving = np.flatnonzero(speed)
    return Table(
        title="Fig 8.4: arm reference",
        columns=("", "value"),
        rows=[
            ("move from [s]", t[moving[0]]),
            ("to [s]", t[moving[-1]]),
            ("largest speed [rad/s]", speed.max()),
        ],
    )


def tracking(file: Path, seed: int) -> Table:
    """Fig 8.5: both sides under feedback alone."""
    runs = chapter8.learned(17.0)
    run, plant = runs.kept[0].result, runs.plant
    t = np.arange(len(run.motor)) * T_S
    figure = new_figure(9.0, 3.6)
    panels = figure.subplots(1, 2)
    for axes, r, q, names, side in (
        (panels[0], plant.motor_reference, run.motor, ("$r_m$", "$q_m$"), "Motor side"),
        (panels[1], plant.arm_reference, run.arm, ("$r_a$", "$q_a$"), "Arm side"),
    ):
        axes.plot(t, r, color=REFERENCE, lw=2.5, label=names[0])
        axes.plot(t, q, color=COLORS[0], label=names[1])
        axes.set_xlim(0.5, 4.0)
        axes.set_title(side, loc="left")
        axes.legend(frameon=False)
    panels[0].set_ylabel("angle [rad]")
    _finish(file, figure, panels, "time [s]")
    return Table(
        title="Fig 8.5: tracking without learning",
        columns=(
            "side",
            "2-norm of the error [rad]",
            "largest error [rad]",
            "overshoot [rad]",
            "reference ends at [rad]",
        ),
        rows=[
            (
                "motor",
                runs.motor[0],
                _largest(plant.motor_reference - run.motor),
                _over(run.motor, 5.0),
                float(plant.motor_reference[-1, 0]),
            ),
            (
                "arm",
                runs.arm[0],
                _largest(plant.arm_reference - run.arm),
                _over(run.arm, 1.0),
                float(plant.arm_reference[-1, 0]),
            ),
        ],
    )


def criterion_curves(file: Path, seed: int) -> Table:
    """Fig 8.6: |1 - L T_u| against 1/|Q|."""
    T_u, omega = LOOP.T_motor, frequency_grid(4000)
    f = hertz(omega, T_S)
    figure = new_figure(7.4, 4.6)
    axes = figure.subplots()
    rows = []
    for delta, color in zip((0, 2, 4, 6), COLORS, strict=False):
        result = heuristic_criterion(T_u, chapter8.GAMMA, delta, ALL_PASS, omega)
        axes.semilogx(f, _decibel(result.learning), color=color, label=f"δ = {delta}")
        worst = float(hertz(result.limiting_omega, T_S))
        met = [
            "yes"
            if heuristic_criterion(
                T_u, chapter8.GAMMA, delta, ZeroPhaseButterworth(cutoff, T_S), omega
            ).is_met
            else "no"
            for cutoff in (11.0, 22.0, 38.0)
        ]
        edge = largest_cutoff(T_u, chapter8.GAMMA, delta)
        rows.append((delta, float(_decibel(result.contraction)), worst, edge, *met))
    for cutoff in (11.0, 22.0, 38.0):
        Q = ZeroPhaseButterworth(cutoff, T_S).response(omega[:-1])
        axes.semilogx(f[:-1], -_decibel(Q), color=INK, lw=1.0, ls="--")
        labelled = f[np.searchsorted(-_decibel(Q), 2.4)]
        axes.text(labelled, 2.4, f"{cutoff:g} Hz ", color=INK, fontsize=8, ha="right")
    axes.axhline(0.0, color=INK, lw=1.0)
    axes.text(2.1, 0.08, "1/|Q| for Q = 1", color=INK, fontsize=8)
    axes.set_xlim(2, 45)
    axes.set_ylim(-3, 3)
    axes.set_xticks([2, 5, 10, 20, 40], ["2", "5", "10", "20", "40"])
    axes.set_xticks([], minor=True)
    axes.set_ylabel("magnitude [dB]")
    axes.set_title("|1 − LTᵤ| (solid) must stay below 1/|Q| (dashed), γ = 0.9", loc="left")
    axes.legend(frameon=False, loc="lower right")
    _finish(file, figure, [axes], "frequency [Hz]")
    return Table(
        title="Fig 8.6: criterion with gamma = 0.9, motor side",
        columns=(
            "delta",
            "max |1-LTu| [dB]",
            "at [Hz]",
            "largest cutoff [Hz]",
            "11 Hz met",
            "22 Hz met",
            "38 Hz met",
        ),
        rows=rows,
    )


def gamma_maps(file: Path, seed: int) -> Table:
    """Fig 8.7: admissible gain over shift and cutoff."""
    shifts, cutoffs = chapter8.SHIFTS, chapter8.SEARCHED_CUTOFFS
    figure = new_figure(10.0, 4.2)
    figure.set_layout_engine("constrained")
    panels = figure.subplots(1, 2, sharey=True)
    rows = []
    look = {"vmin": 0.0, "vmax": 2.0, "cmap": "viridis"}
    for axes, (side, T_u) in zip(
        panels, (("motor", LOOP.T_motor), ("arm", LOOP.T_arm)), strict=True
    ):
        gain = largest_gamma(T_u, shifts, cutoffs)
        weighted = gain * T_u.static_gain
        axes.pcolormesh(shifts, cutoffs, weighted.T, **look)
        best = weighted.argmax(axis=0)
        of_fives = shifts[::5][weighted[::5].argmax(axis=0)]
        at_thesis = gain[shifts == THESIS_SHIFT[side]][0]
        seen = weighted.max(axis=0) > 1e-3
        axes.plot(shifts[best][seen], cutoffs[seen], color="white", lw=1.2)
        axes.set_title(f"Learning from the {side}", loc="left")
        axes.set_xlabel("shift δ [samples]")
        for cutoff in (0.5, 1.0, 5.0, 10.0, 17.0, 25.0, 30.0):
            column = int(np.abs(cutoffs - cutoff).argmin())
            i = best[column]
            rows.append(
                (
                    side,
                    cutoff,
                    int(shifts[i]),
                    gain[i, column],
                    weighted[i, column],
                    int(of_fives[column]),
                    at_thesis[column],
                )
            )
    panels[0].set_ylabel("cutoff of Q [Hz]")
    bar = figure.colorbar(
        panels[0].collections[0], ax=panels, label="largest γ · |Tᵤ(0)|   (white: best shift)"
    )
    bar.outline.set_visible(False)  # type: ignore[operator]
    save(figure, file)
    return Table(
        title="Fig 8.7: best shift and largest admissible gain",
        columns=(
            "side",
            "cutoff [Hz]",
            "best delta",
            "largest gamma",
            "gamma |Tu(0)|",
            "best multiple of 5",
            AT_THESIS_SHIFT,
        ),
        rows=rows,
    )


def learning_curves(file: Path, seed: int) -> Table:
    """Fig 8.8: 500 iterations with Q = 1 and with three filters."""
    figure = new_figure(9.6, 4.0)
    panels = figure.subplots(1, 2, sharey=True)
    without = {
        AS_STATED: chapter8.learned(None),
        ONE_LESS: chapter8.learned(None, delta=4),
    }
    filtered = {f"{f:g} Hz": chapter8.learned(f) for f in chapter8.CUTOFFS}
    for axes, runs, title in (
        (panels[0], without, "Without Q: better at first, then it grows"),
        (panels[1], filtered, "With Q: it stays"),
    ):
        for (name, run), color in zip(runs.items(), COLORS, strict=False):
            axes.semilogy(run.motor / run.motor[0], color=color, label=name)
        axes.set_title(title, loc="left")
        axes.legend(frameon=False)
    panels[0].set_ylabel("motor error, 2-norm over its first")
    _finish(file, figure, panels, "iteration k")
    return Table(
        title="Fig 8.8: 2-norm of the motor error [rad]",
        columns=("", *(f"k = {k}" for k in COUNTED), "smallest", "at k"),
        rows=[
            (name, *run.motor[list(COUNTED)], run.motor.min(), int(run.motor.argmin()))
            for name, run in (without | filtered).items()
        ],
    )


def motor_signals(file: Path, seed: int) -> Table:
    """Fig 8.9: motor angle over iterations."""
    return _signals(file, chapter8.learned(17.0), "motor", "Fig 8.9: motor side, ideal F_r")


def arm_signals(file: Path, seed: int) -> Table:
    """Fig 8.10: arm angle over iterations, ideal reference filter."""
    return _signals(file, chapter8.learned(17.0), "arm", "Fig 8.10: arm side, ideal F_r")


def arm_signals_with_error(file: Path, seed: int) -> Table:
    """Fig 8.12: arm angle over iterations, doubled stiffness in the reference filter."""
    runs = chapter8.learned(17.0, stiffness_factor=2.0)
    return _signals(file, runs, "arm", "Fig 8.12: arm side, stiffness doubled in F_r")


def model_error(file: Path, seed: int) -> Table:
    """Fig 8.11: both sides with an ideal and a wrong reference filter."""
    runs = {
        "ideal model": chapter8.learned(17.0),
        "model error": chapter8.learned(17.0, stiffness_factor=2.0),
    }
    figure = new_figure(9.6, 4.0)
    panels = figure.subplots(1, 2, sharey=True)
    rows = []
    for axes, side in zip(panels, ("motor", "arm"), strict=True):
        for (name, run), color in zip(runs.items(), COLORS, strict=False):
            norms = getattr(run, side)
            axes.semilogy(norms / norms[0], color=color, label=name)
            rows.append((side, name, *norms[list(COUNTED)]))
        axes.set_title(f"{side.capitalize()} side", loc="left")
        axes.legend(frameon=False)
    panels[0].set_ylabel("error, 2-norm over its first")
    _finish(file, figure, panels, "iteration k")
    return Table(
        title="Fig 8.11: 2-norms [rad]; model error: stiffness doubled in F_r",
        columns=("side", "F_r", *(f"k = {k}" for k in COUNTED)),
        rows=rows,
    )


def nyquist(file: Path, seed: int) -> Table:
    """Learning transients: the Nyquist curve of L T_u and the unit circle at +1 (thesis 7.4)."""
    omega = frequency_grid(4000)
    f = hertz(omega, T_S)
    figure = new_figure(9.0, 4.6)
    panels = figure.subplots(1, 2)
    turn = unit_circle(np.linspace(0, 2 * np.pi, 400))
    rows = []
    for axes in panels:
        axes.fill((1 + turn).real, (1 + turn).imag, color="#EEF3E8")
        axes.plot((1 + turn).real, (1 + turn).imag, color=INK, lw=1.0)
        for delta, color in zip((0, 2, 4, 6), COLORS, strict=False):
            curve = shift_response(chapter8.GAMMA, delta, omega) * LOOP.T_motor.response(omega)
            axes.plot(curve.real, curve.imag, color=color, label=f"δ = {delta}")
        axes.set_aspect("equal")
        axes.set_xlabel("real part of LTᵤ")
    panels[0].set_ylabel("imaginary part")
    panels[0].set_xlim(-0.4, 2.1)
    panels[0].set_ylim(-1.1, 1.1)
    panels[1].set_xlim(-0.08, 0.08)
    panels[1].set_ylim(-0.08, 0.08)
    panels[0].set_title("Inside the circle, a frequency is learned", loc="left")
    panels[1].set_title("Near the origin every curve leaves it", loc="left")
    panels[0].legend(frameon=False, loc="upper right")
    save(figure, file)
    for delta in (0, 2, 4, 6):
        result = heuristic_criterion(LOOP.T_motor, chapter8.GAMMA, delta, ALL_PASS, omega)
        outside = np.flatnonzero(result.learning >= 1.0)
        rows.append((delta, f[outside[0]], result.contraction))
    return Table(
        title="Nyquist view: where L T_u leaves the unit circle at +1, gamma = 0.9",
        columns=("delta", "leaves at [Hz]", "largest |1-LTu|"),
        rows=rows,
    )


def algorithms(file: Path, seed: int) -> Table:
    """Algorithms 1 to 3 of thesis 7.5 on the same joint."""
    figure = new_figure(7.0, 4.0)
    axes = figure.subplots()
    rows = []
    plant = chapter8.learned(17.0).plant
    for (name, law), color in zip(chapter8.algorithms().items(), COLORS, strict=False):
        norms = chapter8.run(plant, law, 100).motor
        axes.loglog(np.arange(1, 102), norms / norms[0], color=color, label=name)
        reached = chapter8.iterations_to(norms, 0.05)
        rows.append((name, norms[1], norms[5], norms[100], norms[100] / norms[0], reached))
    axes.set_title("Motor error of three designs", loc="left")
    axes.set_ylabel("2-norm over its first")
    axes.legend(frameon=False)
    _finish(file, figure, [axes], "iteration k + 1")
    return Table(
        title="Algorithms 1 to 3: 2-norm of the motor error [rad]",
        columns=("algorithm", "k = 1", "k = 5", "k = 100", "k = 100 / k = 0", "k at 5 %"),
        rows=rows,
    )


def robustness(file: Path, seed: int) -> Table:
    """Contraction over uncertain joints: a map and a Monte Carlo."""
    factors = np.geomspace(0.2, 5.0, 25)
    design = Design(gamma=chapter8.GAMMA, delta=chapter8.DELTA, Q=ZeroPhaseButterworth(17.0, T_S))
    figure = new_figure(10.0, 4.2)
    left, right = figure.subplots(1, 2)
    grid = contraction_map(LOOP, design, ("Jm", factors), ("k", factors))
    mesh = left.pcolormesh(factors, factors, grid, vmin=0.7, vmax=1.3, cmap="RdYlGn_r")
    left.contour(factors, factors, grid, levels=[1.0], colors=INK)
    left.set_xscale("log")
    left.set_yscale("log")
    for axis in (left.xaxis, left.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_ticks([0.2, 0.5, 1, 2, 5])
        axis.set_ticks([], minor=True)
    left.set_xlabel("stiffness k, times nominal")
    left.set_ylabel("motor inertia Jₘ, times nominal")
    left.set_title("Worst |Q(1 − LTᵤ)|; line: 1", loc="left")
    figure.colorbar(mesh, ax=left).outline.set_visible(False)  # type: ignore[operator]
    rows = []
    rng = np.random.default_rng(seed)
    for spread, color in zip((0.2, 0.5, 1.0), COLORS, strict=False):
        sampled = monte_carlo(LOOP, design, spread, 200, rng)
        x = np.sort(sampled.contraction)
        right.plot(
            x, np.linspace(0, 100, len(x)), color=color, label=f"factors up to {1 + spread:g}"
        )
        converge = 100 * sampled.share_converging
        rows.append((f"{1 + spread:g}", converge, x[-1], sampled.most_harmful()))
    right.axvline(1.0, color=INK, lw=1.0)
    right.set_xlabel("worst |Q(1 − LTᵤ)|")
    right.set_ylabel("joints at or below [%]")
    right.set_title("All parameters uncertain, 200 joints each", loc="left")
    right.legend(frameon=False)
    save(figure, file)
    return Table(
        title="Robustness of gamma = 0.9, delta = 5, 17 Hz to the joint's parameters",
        columns=("factors up to", "contract [%]", "worst contraction", "most harmful"),
        rows=rows,
    )


def friction(file: Path, seed: int) -> Table:
    """Coulomb friction and measurement noise in the joint."""
    law = Heuristic(Q=ZeroPhaseButterworth(17.0, T_S), gamma=chapter8.GAMMA, delta=chapter8.DELTA)
    cases = ((0.0, 0.0), (0.05, 0.0), (0.2, 0.0), (0.05, 0.01))
    figure = new_figure(9.6, 4.0)
    panels = figure.subplots(1, 2)
    rows = []
    for (c, noise), color in zip(cases, COLORS, strict=False):
        rng = np.random.default_rng(seed)
        plant = FrictionPlant(coulomb=c, noise=noise, rng=rng)
        runs = chapter8.run(plant, law, 50)
        name = f"c = {c:g} N m" + (f", noise {noise:g} rad" if noise else "")
        for axes, norms in zip(panels, (runs.motor, runs.arm), strict=True):
            axes.semilogy(norms, color=color, label=name)
        rows.append((name, *runs.motor[[0, 5, 50]], *runs.arm[[0, 5, 50]]))
    for axes, side in zip(panels, ("Motor", "Arm"), strict=True):
        axes.set_title(f"{side} side", loc="left")
    panels[0].set_ylabel("2-norm of the error [rad]")
    panels[1].legend(frameon=False)
    _finish(file, figure, panels, "iteration k")
    return Table(
        title="Coulomb friction c and measurement noise: 2-norms [rad] at k = 0, 5, 50",
        columns=("", "motor 0", "motor 5", "motor 50", "arm 0", "arm 5", "arm 50"),
        rows=rows,
    )


def why_q(file: Path, seed: int) -> Table:
    """Why no shift makes Q = 1 possible, and how little a model must know to do it."""
    omega = frequency_grid(4000)
    f = hertz(omega, T_S)
    T_u = LOOP.T_motor
    phase = np.degrees(np.unwrap(np.angle(T_u.response(omega))))
    figure = new_figure(10.5, 4.6)
    left, right = figure.subplots(1, 2)
    for axes in (left, right):
        axes.axhspan(-90, 90, color="#EEF3E8")
        axes.set_xlim(0.2, 50)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    rows = []
    for delta, color in zip((0, 1, 2, 3, 5), COLORS, strict=False):
        turned = phase + np.degrees(delta * omega)
        left.plot(f, turned, color=color, label=f"δ = {delta}")
        rows.append((f"shift, delta = {delta}", *_beyond(f, turned)))
    for (name, model), color in zip(chapter8.rough_models().items(), COLORS, strict=False):
        turned = np.degrees(chapter8.phase_error(model, T_u, omega))
        right.plot(f, turned, color=color, label=name)
        rows.append((f"model backwards: {name}", *_beyond(f, turned)))
    left.text(0.25, 66, "here a small enough gain learns", color=INK, fontsize=9)
    left.set_ylim(-270, 360)
    left.set_yticks([-270, -180, -90, 0, 90, 180, 270, 360])
    right.set_ylim(-190, 190)
    right.set_yticks([-180, -90, 0, 90, 180])
    left.set_ylabel("phase of LTᵤ [°]")
    left.set_title("L a shift: none stays within ± 90°", loc="left")
    right.set_title("L a rough model run backwards: most do", loc="left")
    left.legend(frameon=False, loc="upper left")
    right.legend(frameon=False, loc="upper left", fontsize=8, bbox_to_anchor=(0.0, 0.98))
    _finish(file, figure, [left, right], "frequency [Hz]")
    return Table(
        title="Why Q: where the phase of L Tu is beyond 90 degrees, with Q = 1",
        columns=("L", "first [Hz]", "last [Hz]", "largest phase [deg]"),
        rows=rows,
    )


def _beyond(f: Array, degrees: Array) -> tuple[float | str, float | str, float]:
    """First and last frequency at which an angle is beyond 90 degrees, and its largest size."""
    size = np.abs((degrees + 180.0) % 360.0 - 180.0)
    bad = np.flatnonzero(size >= 90.0)
    first, last = (float(f[bad[0]]), float(f[bad[-1]])) if bad.size else ("none", "none")
    return first, last, float(size.max())


def _signals(file: Path, runs: chapter8.Learning, side: str, title: str) -> Table:
    """Angle and error of one side at the iterations of `SHOWN`."""
    plant = runs.plant
    r = plant.motor_reference if side == "motor" else plant.arm_reference
    t = np.arange(len(r)) * T_S
    letter = side[0]
    figure = new_figure(10.5, 4.6)
    grid = figure.subplots(2, len(SHOWN), sharex=True, sharey="row")
    rows = []
    for column, k in enumerate(SHOWN):
        q = getattr(runs.kept[k].result, side)
        upper, lower = grid[:, column]
        upper.plot(t, r, color=REFERENCE, lw=2.5, label=f"$r_{letter}$")
        upper.plot(t, q, color=COLORS[0], label=f"$q_{letter}$")
        lower.plot(t, r - q, color=COLORS[1])
        upper.set_title(f"k = {k}", loc="left")
    for k, trial in runs.kept.items():
        q = getattr(trial.result, side)
        rows.append((k, getattr(runs, side)[k], _largest(r - q), _over(q, float(r[-1, 0]))))
    grid[0, 0].legend(frameon=False)
    grid[0, 0].set_ylabel("angle [rad]")
    grid[1, 0].set_ylabel("error [rad]")
    grid[0, 0].set_xlim(0.5, 6.0)
    _finish(file, figure, grid.ravel(), "time [s]", only_last=True)
    return Table(
        title=title,
        columns=("k", "2-norm [rad]", "largest error [rad]", "overshoot [rad]"),
        rows=rows,
    )


def _finish(
    file: Path, figure: Any, panels: Sequence[Axes], xlabel: str, *, only_last: bool = False
) -> None:
    for axes in panels:
        axes.grid(True, which="major", color="#DDDDDD", lw=0.6)
        if not only_last or axes.get_subplotspec().is_last_row():  # type: ignore[union-attr]
            axes.set_xlabel(xlabel)
    figure.set_layout_engine("constrained")
    save(figure, file)


def _decibel(value: Any) -> Any:
    return 20.0 * np.log10(np.abs(value))


def _resonance() -> float:
    """[Hz], undamped, of the arm on its spring."""
    return float(np.sqrt(LOOP.joint.k / LOOP.joint.Ja) / (2 * np.pi))


def _largest(error: Any) -> float:
    return float(np.abs(error).max())


def _over(signal: Any, goal: float) -> float:
    return float(np.max(signal) - goal)


FIGURES = {
    "8.3": bode,
    "8.4": reference,
    "8.5": tracking,
    "8.6": criterion_curves,
    "8.7": gamma_maps,
    "8.8": learning_curves,
    "8.9": motor_signals,
    "8.10": arm_signals,
    "8.11": model_error,
    "8.12": arm_signals_with_error,
    "nyquist": nyquist,
    "why-q": why_q,
    "algorithms": algorithms,
    "robustness": robustness,
    "friction": friction,
}
"""By the number in the thesis, or by name for what the thesis leaves to others."""
