"""Figure of the eigenloci of coupled motors: Q (1 - L T_u) inside the unit circle."""

from pathlib import Path

import numpy as np

from armside.ilc.analysis import Eigenloci, hertz
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
