"""Figures 8.3 to 8.12 of the thesis: each function draws one PNG and returns its table."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from armside.ilc import analysis
from armside.ilc.analysis import frequency_grid, hertz, heuristic_criterion
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.two_mass_study import CUTOFFS, SEARCHED_CUTOFFS, Study
from armside.ilc.two_mass_study import SHIFTS as SEARCHED_SHIFTS
from armside.sim.evaluation.check import Table

from . import two_mass_designs as designs
from .canvas import COLORS, INK, REFERENCE, panels
from .two_mass_designs import NYQUIST_SHIFTS, THESIS, charts, decibel

SHOWN = (0, 1, 2, 5)
"""Iterations of the time signals."""
COUNTED = (0, 1, 2, 3, 5, 10, 25, 100, 500)
"""Iterations in the tables."""
FILTERS = (11.0, 22.0, 38.0)
"""Cutoffs of Fig 8.6 [Hz]."""
THESIS_SHIFT = {"motor": 5, "arm": 15}
"""The best shift of each side, as the thesis has it in 8.4.2."""
AT_THESIS_SHIFT = "gamma, delta 5 (arm 15)"
IDEAL, DOUBLED = "side, ideal F_r", "side, stiffness doubled in F_r"
AS_STATED, ONE_LESS = "Q = 1, δ = 5 (as stated)", "Q = 1, δ = 4 (fits the figure)"


def bode(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Fig 8.3: the motor's notch coincides with the arm's peak."""
    omega = np.geomspace(2e-3, np.pi * 0.999, 4000)
    joint, T_s = of.loop.joint, of.loop.sample_time
    f = hertz(omega, T_s)
    G_m, G_a = (G.response(omega) for G in (joint.motor(T_s), joint.arm(T_s)))
    titles = ["Voltage to motor, motor to arm, voltage to arm"]
    labels = "frequency [Hz]", "magnitude [dB]"
    with charts(file, (7.0, 5.6), 2, titles=titles, labels=labels, legends=[0], sharex=True) as (
        upper,
        lower,
    ):
        for name, response in (("$G_m$", G_m), ("$G_a$", G_a), ("$G_a G_m$", G_m * G_a)):
            upper.semilogx(f, decibel(response), label=name)
            lower.semilogx(f, np.degrees(np.unwrap(np.angle(response))))
        upper.set_ylim(-90, 10)
        lower.set_ylabel("phase [°]")
    arm, motor = decibel(G_a), decibel(G_m)
    undamped = float(np.sqrt(joint.k / joint.Ja) / (2 * np.pi))
    near = (f > 0.44 * undamped) & (f < 1.24 * undamped)
    notch, peak = np.flatnonzero(near)[motor[near].argmin()], arm.argmax()
    rows = [
        ("peak of the arm, G_a", f[peak], arm[peak]),
        ("notch of the motor, G_m", f[notch], motor[notch]),
        ("zeros of G_m(s) = poles of G_a(s)", undamped, ""),
    ]
    return Table("Fig 8.3: discrete joint", ("", "frequency [Hz]", "magnitude [dB]"), rows)


def reference(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Fig 8.4: the arm reference and its speed."""
    r_a = of.learned().plant.arm_reference[:, 0]
    speed = np.diff(r_a, prepend=0.0) / of.loop.sample_time
    t = np.arange(len(r_a)) * of.loop.sample_time
    titles, labels = ["Arm reference"], ("time [s]", "")
    with charts(file, (7.0, 3.6), titles=titles, labels=labels, legends=[0]) as (axes,):
        axes.plot(t, r_a, label="$r_a$ [rad]")
        axes.plot(t, speed, label="its speed [rad/s]")
        axes.set_xlim(0.5, 2.5)
    moving = np.flatnonzero(speed)
    rows = [("move from [s]", t[moving[0]]), ("to [s]", t[moving[-1]])]
    rows.append(("largest speed [rad/s]", speed.max()))
    return Table("Fig 8.4: arm reference", ("", "value"), rows)


def tracking(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Fig 8.5: both sides under feedback alone."""
    runs = of.learned()
    run, plant = runs.kept[0].result, runs.plant
    t = np.arange(len(run.motor)) * of.loop.sample_time
    rows = []
    titles, labels = ("Motor side", "Arm side"), ("time [s]", "angle [rad]")
    with charts(file, (9.0, 3.6), 1, 2, titles=titles, labels=labels, legends=[0, 1]) as grid:
        for axes, side, r, q, norms in (
            (grid[0], "motor", plant.motor_reference, run.motor, runs.motor),
            (grid[1], "arm", plant.arm_reference, run.arm, runs.arm),
        ):
            axes.plot(t, r, color=REFERENCE, lw=2.5, label=f"$r_{side[0]}$")
            axes.plot(t, q, label=f"$q_{side[0]}$")
            axes.set_xlim(0.5, 4.0)
            goal = 1.0 / of.loop.joint.rg if side == "motor" else 1.0
            rows.append((side, norms[0], *_extremes(r, q, goal), float(r[-1, 0])))
    errors = ("2-norm of the error [rad]", "largest error [rad]", "overshoot [rad]")
    columns = ("side", *errors, "reference ends at [rad]")
    return Table("Fig 8.5: tracking without learning", columns, rows)


def criterion_curves(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Fig 8.6: |1 - L T_u| against 1/|Q|."""
    T_u, omega = of.loop.T_motor, frequency_grid(4000)
    f = hertz(omega, of.loop.sample_time)
    Q = {cutoff: ZeroPhaseButterworth(cutoff, of.loop.sample_time) for cutoff in FILTERS}
    rows = []
    titles = [f"|1 − LTᵤ| (solid) must stay below 1/|Q| (dashed), γ = {of.gamma:g}"]
    labels = "frequency [Hz]", "magnitude [dB]"
    with charts(file, (7.4, 4.6), titles=titles, labels=labels) as (axes,):
        for delta in NYQUIST_SHIFTS:
            result = heuristic_criterion(T_u, of.gamma, delta, ALL_PASS, omega)
            axes.semilogx(f, decibel(result.learning), label=f"δ = {delta}")
            worst = float(hertz(result.limiting_omega, of.loop.sample_time))
            met = [heuristic_criterion(T_u, of.gamma, delta, q, omega).is_met for q in Q.values()]
            edge = analysis.largest_cutoff(T_u, of.gamma, delta)
            answers = ("yes" if each else "no" for each in met)
            rows.append((delta, float(decibel(result.contraction)), worst, edge, *answers))
        for cutoff in FILTERS:
            bound = -decibel(Q[cutoff].response(omega[:-1]))
            axes.semilogx(f[:-1], bound, color=INK, lw=1.0, ls="--")
            labelled = f[np.searchsorted(bound, 2.4)]
            axes.text(labelled, 2.4, f"{cutoff:g} Hz ", color=INK, fontsize=8, ha="right")
        axes.axhline(0.0, color=INK, lw=1.0)
        axes.text(2.1, 0.08, "1/|Q| for Q = 1", color=INK, fontsize=8)
        axes.set(xlim=(2, 45), ylim=(-3, 3))
        axes.set_xticks([2, 5, 10, 20, 40], ["2", "5", "10", "20", "40"])
        axes.set_xticks([], minor=True)
        axes.legend(loc="lower right")
    criteria = ("delta", "max |1-LTu| [dB]", "at [Hz]", "largest cutoff [Hz]")
    columns = (*criteria, *(f"{cutoff:g} Hz met" for cutoff in FILTERS))
    return Table(f"Fig 8.6: criterion with gamma = {of.gamma:g}, motor side", columns, rows)


def gamma_maps(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Fig 8.7: admissible gain over shift and cutoff."""
    shifts, cutoffs = SEARCHED_SHIFTS, SEARCHED_CUTOFFS
    rows = []
    titles = [f"Learning from the {side}" for side in THESIS_SHIFT]
    labels = "shift δ [samples]", "cutoff of Q [Hz]"
    with panels(
        file, (10.0, 4.2), 1, 2, titles=titles, labels=labels, large=True, sharey=True
    ) as grid:
        for axes, side in zip(grid, THESIS_SHIFT, strict=True):
            T_u = of.loop.T_motor if side == "motor" else of.loop.T_arm
            gain = analysis.largest_gamma(T_u, shifts, cutoffs)
            weighted = gain * T_u.static_gain
            axes.pcolormesh(shifts, cutoffs, weighted.T, vmin=0.0, vmax=2.0, cmap="viridis")
            best = weighted.argmax(axis=0)
            of_fives = shifts[::5][weighted[::5].argmax(axis=0)]
            at_thesis = gain[shifts == THESIS_SHIFT[side]][0]
            seen = weighted.max(axis=0) > 1e-3
            axes.plot(shifts[best][seen], cutoffs[seen], color="white", lw=1.2)
            for cutoff in (0.5, 1.0, 5.0, 10.0, 17.0, 25.0, 30.0):
                j = int(np.abs(cutoffs - cutoff).argmin())
                i = best[j]
                gains = (gain[i, j], weighted[i, j])
                rows.append((side, cutoff, int(shifts[i]), *gains, int(of_fives[j]), at_thesis[j]))
        label = "largest γ · |Tᵤ(0)|   (white: best shift)"
        bar = grid[0].figure.colorbar(grid[0].collections[0], ax=list(grid), label=label)
        bar.outline.set_visible(False)
    found = ("side", "cutoff [Hz]", "best delta", "largest gamma", "gamma |Tu(0)|")
    columns = (*found, "best multiple of 5", AT_THESIS_SHIFT)
    return Table("Fig 8.7: best shift and largest admissible gain", columns, rows)


def learning_curves(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Fig 8.8: 500 iterations with Q = 1 and with three filters."""
    as_stated, one_less = AS_STATED, ONE_LESS
    if not of.is_thesis:
        as_stated, one_less = (f"Q = 1, δ = {delta}" for delta in (of.delta, of.delta - 1))
    without = {as_stated: of.heuristic(None), one_less: of.heuristic(None, of.delta - 1)}
    filtered = {f"{f:g} Hz": of.heuristic(f) for f in CUTOFFS}
    if of.law is not None:
        filtered[of.name] = of.learned()
    titles = ("Without Q", "With Q")
    if of.is_thesis:
        titles = ("Without Q: better at first, then it grows", "With Q: it stays")
    labels, size = ("iteration k", "motor error, 2-norm over its first"), (9.6, 4.0)
    with charts(
        file, size, 1, 2, titles=titles, labels=labels, legends=[0, 1], sharey=True
    ) as grid:
        for axes, runs in zip(grid, (without, filtered), strict=True):
            for name, run in runs.items():
                axes.semilogy(run.motor / run.motor[0], label=name)
    rows = [
        (
            *(name, *run.motor[list(COUNTED)], run.motor.min(), int(run.motor.argmin())),
            float((run.motor / np.minimum.accumulate(run.motor)).max() - 1.0),
        )
        for name, run in (without | filtered).items()
    ]
    columns = ("", *(f"k = {k}" for k in COUNTED), "smallest", "at k", "largest rise")
    return Table("Fig 8.8: 2-norm of the motor error [rad]", columns, rows)


def model_error(file: Path, seed: int, of: Study = THESIS) -> Table:
    """Fig 8.11: both sides with an ideal and a wrong reference filter."""
    runs = {"ideal model": of.learned(), "model error": of.learned(2.0)}
    rows = []
    titles, labels = ("Motor side", "Arm side"), ("iteration k", "error, 2-norm over its first")
    with charts(
        file, (9.6, 4.0), 1, 2, titles=titles, labels=labels, legends=[0, 1], sharey=True
    ) as grid:
        for axes, side in zip(grid, ("motor", "arm"), strict=True):
            for name, run in runs.items():
                norms = getattr(run, side)
                axes.semilogy(norms / norms[0], label=name)
                rows.append((side, name, *norms[list(COUNTED)]))
    columns = ("side", "F_r", *(f"k = {k}" for k in COUNTED))
    return Table("Fig 8.11: 2-norms [rad]; model error: stiffness doubled in F_r", columns, rows)


def signals(
    file: Path, seed: int, of: Study = THESIS, *, side: str, title: str, stiffness: float = 1.0
) -> Table:
    """Figs 8.9, 8.10, 8.12: angle and error of one side at the iterations of `SHOWN`."""
    runs = of.learned(stiffness)
    plant, letter = runs.plant, side[0]
    r = plant.motor_reference if side == "motor" else plant.arm_reference
    t = np.arange(len(r)) * of.loop.sample_time
    titles, labels = [f"k = {k}" for k in SHOWN], ("time [s]", "angle [rad]")
    shared: dict[str, Any] = {"legends": [0], "sharex": True, "sharey": "row"}
    with charts(file, (10.5, 4.6), 2, len(SHOWN), titles=titles, labels=labels, **shared) as grid:
        uppers, lowers = grid.reshape(2, -1)
        for upper, lower, k in zip(uppers, lowers, SHOWN, strict=True):
            q = getattr(runs.kept[k].result, side)
            upper.plot(t, r, color=REFERENCE, lw=2.5, label=f"$r_{letter}$")
            upper.plot(t, q, label=f"$q_{letter}$")
            lower.plot(t, r - q, color=COLORS[1])
        uppers[0].set_xlim(0.5, 6.0)
        lowers[0].set_ylabel("error [rad]")
    rows = []
    for k, trial in runs.kept.items():
        q = getattr(trial.result, side)
        rows.append((k, getattr(runs, side)[k], *_extremes(r, q, float(r[-1, 0]))))
    return Table(title, ("k", "2-norm [rad]", "largest error [rad]", "overshoot [rad]"), rows)


def _extremes(r: Any, q: Any, goal: float) -> tuple[float, float]:
    """Largest error, and overshoot."""
    return float(np.abs(r - q).max()), float(np.max(q) - goal)


FIGURES = {
    "8.3": bode,
    "8.4": reference,
    "8.5": tracking,
    "8.6": criterion_curves,
    "8.7": gamma_maps,
    "8.8": learning_curves,
    "8.9": partial(signals, side="motor", title=f"Fig 8.9: motor {IDEAL}"),
    "8.10": partial(signals, side="arm", title=f"Fig 8.10: arm {IDEAL}"),
    "8.11": model_error,
    "8.12": partial(signals, side="arm", title=f"Fig 8.12: arm {DOUBLED}", stiffness=2.0),
    "nyquist": designs.nyquist,
    "why-q": designs.why_q,
    "algorithms": designs.algorithms,
    "robustness": designs.robustness,
    "friction": designs.friction,
}
"""By the number in the thesis, or by name for figures that the thesis does not have."""
