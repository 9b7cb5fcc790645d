"""Figures of a design: criterion, Nyquist curve, eigenloci of coupled motors."""

from pathlib import Path

import numpy as np

from armside.ilc.analysis import Eigenloci, hertz
from armside.ilc.analysis.criterion import shift_response
from armside.ilc.analysis.proposal import Proposal
from armside.ilc.models.system import unit_circle

from .laser import COLORS, INK, new_figure, save


def draw_eigenloci(file: Path, title: str, loci: Eigenloci, sample_time: float) -> None:
    """Loci in the plane and their moduli over frequency; the largest is marked."""
    figure = new_figure(9.6, 4.4)
    figure.subplots_adjust(left=0.07, right=0.98, bottom=0.13, top=0.88, wspace=0.2)
    left, right = figure.subplots(1, 2)
    circle = unit_circle(np.linspace(0.0, 2.0 * np.pi, 400))
    left.fill(circle.real, circle.imag, color="#EEF3E8")
    left.plot(circle.real, circle.imag, color=INK, lw=1.0)
    f = hertz(loci.omega, sample_time)
    moving = f > 0.0
    for i, locus in enumerate(loci.values.T):
        color = COLORS[i % len(COLORS)]
        left.plot(locus.real, locus.imag, color=color, lw=1.0)
        right.semilogx(f[moving], np.abs(locus)[moving], color=color, lw=1.0)
    at = int(np.abs(loci.values).max(axis=1).argmax())
    worst = loci.values[at, np.abs(loci.values[at]).argmax()]
    left.plot(worst.real, worst.imag, marker="o", mfc="none", color=INK, ls="none")
    right.axhline(1.0, color=INK, lw=1.0)
    left.set(aspect="equal", xlabel="real part", ylabel="imaginary part")
    left.set_title(f"{title}: eigenvalues of Q (1 − L Tᵤ)", loc="left", fontsize=9)
    right.set(xlabel="frequency [Hz]", ylabel="modulus of each")
    right.set_title(f"largest modulus {abs(worst):.3g}, at {f[at]:.3g} Hz", loc="left", fontsize=9)
    save(figure, file)


def draw_proposal(file: Path, proposal: Proposal) -> None:
    """Draw |1 - L T_u| against 1/|Q|, and L T_u in the unit circle at +1."""
    result, T_u = proposal.criterion, proposal.T_u
    f = hertz(result.omega, T_u.sample_time)
    L = shift_response(proposal.gamma, proposal.delta, result.omega)
    curve = L * T_u.response(result.omega)
    figure = new_figure(9.6, 4.2)
    figure.set_layout_engine("constrained")
    left, right = figure.subplots(1, 2)
    shown = f > proposal.cutoff / 100.0
    with np.errstate(divide="ignore"):
        left.loglog(f[shown], 1.0 / result.q[shown], color=INK, ls="--", label="1/|Q|")
    left.loglog(f[shown], result.learning[shown], color=COLORS[0], label="|1 − LTᵤ|")
    left.set_ylim(0.5 * min(0.1, result.learning[shown].min()), 10.0)
    left.set_xlabel("frequency [Hz]")
    left.set_title("The solid line must stay below the dashed", loc="left")
    left.grid(True, which="major", color="#DDDDDD", lw=0.6)
    left.legend(frameon=False)
    circle = 1.0 + unit_circle(np.linspace(0.0, 2.0 * np.pi, 400))
    right.fill(circle.real, circle.imag, color="#EEF3E8")
    right.plot(circle.real, circle.imag, color=INK, lw=1.0)
    right.plot(curve.real, curve.imag, color="#BBBBBB", label="LTᵤ above the cutoff")
    below = f <= proposal.cutoff
    right.plot(curve[below].real, curve[below].imag, color=COLORS[0], label="LTᵤ below the cutoff")
    right.set(aspect="equal", xlabel="real part", ylabel="imaginary part")
    right.set_title("Learned where the curve is inside the circle", loc="left")
    below_axes = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14), "ncols": 2}
    right.legend(frameon=False, fontsize=8, **below_axes)
    save(figure, file)
