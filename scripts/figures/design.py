"""Figure of a proposed design: criterion over frequency and Nyquist curve of L T_u."""

from pathlib import Path

import numpy as np

from armside.ilc.analysis import hertz
from armside.ilc.analysis.criterion import shift_response
from armside.ilc.analysis.proposal import Proposal
from armside.ilc.models.system import unit_circle

from .laser import COLORS, INK, new_figure, save


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
