"""`armside design`: gain, shift and cutoff for a model, and what to expect of them."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common, options

if TYPE_CHECKING:
    from armside.ilc.analysis.proposal import Proposal
    from armside.ilc.models.system import System

BUILT_IN = ("two-mass", "two-mass-arm", "servo")


@options
@dataclass(frozen=True, kw_only=True)
class DesignCfg:
    """For which model, and how fast."""

    model: str = "two-mass"
    """two-mass or two-mass-arm (chapter 8, learning from motor or arm), servo (the identified
    model (9.12)), or a JSON file with sample_time, b and a (powers of q^-1)."""
    bandwidth: float = 10.0
    """Cutoff of the zero-phase Q: what shall be learned [Hz]."""
    share: float = 0.6
    """Largest part of the admissible gain that is used; the rest is margin."""

    def __post_init__(self) -> None:
        if not self.bandwidth > 0.0:
            raise ValueError(f"bandwidth must be > 0 Hz, got {self.bandwidth:g}")
        if not 0.0 < self.share < 1.0:
            raise ValueError(f"share must be in (0, 1), got {self.share:g}")


def load(name: str) -> "System":
    """The named model, or the one in a file. Raises ValueError."""
    from armside.ilc.models.model_file import read_model
    from armside.ilc.models.system import System
    from armside.ilc.models.two_mass import TwoMassLoop

    if name == "two-mass":
        return TwoMassLoop().T_motor
    if name == "two-mass-arm":
        return TwoMassLoop().T_arm
    if name == "servo":
        # Thesis (9.12), identified on the large robot; 4 ms: the rate of its log.
        return System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], 0.004)  # type: ignore[arg-type]
    if not Path(name).is_file():
        raise ValueError(f"no model {name!r}: give a JSON file or one of {', '.join(BUILT_IN)}")
    return read_model(Path(name))


def design(*, cfg: DesignCfg = DesignCfg(), common: Common = Common()) -> None:
    """Propose gain, shift and cutoff of the heuristic law for a model of T_u.

    Writes design.png (criterion, Nyquist view) and summary.json.
    """
    from armside.ilc.analysis.proposal import propose

    report = Report(common)
    with checking_input():
        proposal = propose(load(cfg.model), cfg.bandwidth, fraction=cfg.share)
    result = {
        "gamma": proposal.gamma,
        "delta": proposal.delta,
        "cutoff": proposal.cutoff,
        "contraction": proposal.contraction,
        "iterations_to_5_percent": proposal.iterations_to_5_percent,
        "largest_gamma": proposal.largest_gamma,
        "largest_cutoff": proposal.largest_cutoff,
        "sentence": proposal.sentence(),
    }
    outcome = summary("design", cfg, common, design=result)
    with RunFolder("design", seed=common.seed, out=common.out) as folder:
        _draw(folder / "design.png", proposal)
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    report.table(
        f"Design for {cfg.model}",
        ("gamma", "delta", "cutoff [Hz]", "contraction", "largest gamma", "largest cutoff [Hz]"),
        [
            (
                proposal.gamma,
                proposal.delta,
                proposal.cutoff,
                proposal.contraction,
                proposal.largest_gamma,
                proposal.largest_cutoff,
            )
        ],
    )
    report.line(proposal.sentence())
    report.line(f"Results in {folder.path}")
    report.summary(outcome)


def _draw(file: Path, proposal: "Proposal") -> None:
    from armside.ilc.analysis import hertz
    from armside.ilc.analysis.criterion import shift_response
    from armside.ilc.models.system import unit_circle

    from ..figures.laser import COLORS, INK, new_figure, save

    result, T_u = proposal.criterion, proposal.T_u
    f = hertz(result.omega, T_u.sample_time)
    curve = shift_response(proposal.gamma, proposal.delta, result.omega) * T_u.response(
        result.omega
    )
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
    turn = 1.0 + unit_circle(np.linspace(0.0, 2.0 * np.pi, 400))
    right.fill(turn.real, turn.imag, color="#EEF3E8")
    right.plot(turn.real, turn.imag, color=INK, lw=1.0)
    right.plot(curve.real, curve.imag, color="#BBBBBB", label="LTᵤ above the cutoff")
    below = f <= proposal.cutoff
    right.plot(curve[below].real, curve[below].imag, color=COLORS[0], label="LTᵤ below the cutoff")
    right.set_aspect("equal")
    right.set_xlabel("real part")
    right.set_ylabel("imaginary part")
    right.set_title("Learned where the curve is inside the circle", loc="left")
    right.legend(frameon=False, fontsize=8, loc="lower left")
    save(figure, file)
