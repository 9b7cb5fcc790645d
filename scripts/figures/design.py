"""Figures of a design: criterion, Nyquist curve, eigenloci of coupled motors."""

from pathlib import Path
from typing import Any

import numpy as np

from armside.ilc.analysis import Eigenloci, hertz
from armside.ilc.analysis.criterion import shift_response
from armside.ilc.analysis.proposal import Proposal
from armside.ilc.models.system import unit_circle

from .canvas import COLORS, INK, panels

DISC = unit_circle(np.linspace(0.0, 2.0 * np.pi, 400))


def draw_disc(axes: Any, centre: float) -> None:
    """The unit circle about a real number, filled, in the complex plane."""
    axes.fill(centre + DISC.real, DISC.imag, color="#EEF3E8")
    axes.plot(centre + DISC.real, DISC.imag, color=INK, lw=1.0)
    axes.set(aspect="equal")


def draw_eigenloci(file: Path, title: str, loci: Eigenloci, sample_time: float) -> None:
    """Loci in the plane and their moduli over frequency; the largest is marked."""
    f = hertz(loci.omega, sample_time)
    moving = f > 0.0
    at = int(np.abs(loci.values).max(axis=1).argmax())
    worst = loci.values[at, np.abs(loci.values[at]).argmax()]
    largest = f"largest modulus {abs(worst):.3g}, at {f[at]:.3g} Hz"
    titles, edges = (f"{title}: eigenvalues of Q (1 − L Tᵤ)", largest), (0.07, 0.98, 0.13, 0.88)
    with panels(file, (9.6, 4.4), 1, 2, titles=titles, edges=edges, gaps=(0.2, None)) as (
        left,
        right,
    ):
        draw_disc(left, 0.0)
        left.plot(loci.values.real, loci.values.imag, lw=1.0)
        right.semilogx(f[moving], np.abs(loci.values)[moving], lw=1.0)
        left.plot(worst.real, worst.imag, marker="o", mfc="none", color=INK, ls="none")
        right.axhline(1.0, color=INK, lw=1.0)
        left.set(xlabel="real part", ylabel="imaginary part")
        right.set(xlabel="frequency [Hz]", ylabel="modulus of each")


def draw_proposal(file: Path, proposal: Proposal) -> None:
    """Draw |1 - L T_u| against 1/|Q|, and L T_u in the unit circle at +1."""
    result, T_u = proposal.criterion, proposal.T_u
    f = hertz(result.omega, T_u.sample_time)
    L = shift_response(proposal.gamma, proposal.delta, result.omega)
    curve = L * T_u.response(result.omega)
    shown, below = f > proposal.cutoff / 100.0, f <= proposal.cutoff
    titles = (
        "The solid line must stay below the dashed",
        "Learned where the curve is inside the circle",
    )
    with panels(file, (9.6, 4.2), 1, 2, titles=titles, legends=[0], large=True) as (left, right):
        with np.errstate(divide="ignore"):
            left.loglog(f[shown], 1.0 / result.q[shown], color=INK, ls="--", label="1/|Q|")
        left.loglog(f[shown], result.learning[shown], color=COLORS[0], label="|1 − LTᵤ|")
        left.set_ylim(0.5 * min(0.1, result.learning[shown].min()), 10.0)
        left.set_xlabel("frequency [Hz]")
        left.grid(True)
        draw_disc(right, 1.0)
        for part, where, color in ((curve, "above", "#BBBBBB"), (curve[below], "below", COLORS[0])):
            right.plot(part.real, part.imag, color=color, label=f"LTᵤ {where} the cutoff")
        right.set(xlabel="real part", ylabel="imaginary part")
        right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize=8)
