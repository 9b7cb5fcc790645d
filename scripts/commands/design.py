"""`armside design`: gain, shift and cutoff for a model, and the convergence to expect."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from armside.sim.records.files import check_file
from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.errors import checking_input
from ..shell.options import Common, Limits, options

if TYPE_CHECKING:
    from armside.ilc.models.system import System

BUILT_IN = ("two-mass", "two-mass-arm", "servo")
LARGEST_MODEL = 50_000
"""[bytes], of a model's file: thousands of coefficients."""
LOWEST = 1e-3
"""Lowest cutoff over the Nyquist frequency."""
NUMBERS = ("gamma", "delta", "cutoff", "contraction", "largest_gamma", "largest_cutoff")
HEADS = ("gamma", "delta", "cutoff [Hz]", "contraction", "largest gamma", "largest cutoff [Hz]")


@options
@dataclass(frozen=True, kw_only=True)
class DesignCfg:
    """Model and cutoff of the design."""

    model: str = "two-mass"
    """two-mass, two-mass-arm, servo, or a JSON file. The joint of chapter 8, learning from motor or
    arm; the identified model (9.12); a file with sample_time, b and a (powers of q^-1)."""
    cutoff: float = 10.0
    """Cutoff of Q [Hz]. Zero-phase: the bandwidth of learning."""
    share: float = 0.6
    """Fraction of the admissible gain that is used; the rest is margin."""

    def __post_init__(self) -> None:
        Limits(0.0, unit="Hz", above=True).check("cutoff", self.cutoff)
        Limits(0.0, 1.0, above=True, below=True).check("share", self.share)


def load(name: str) -> "System":
    """The named model, or the one in a file. Raises ValueError."""
    from armside.ilc.models.file import read_system
    from armside.ilc.models.system import System
    from armside.ilc.models.two_mass import TwoMassLoop

    if name in ("two-mass", "two-mass-arm"):
        loop = TwoMassLoop()
        return loop.T_motor if name == "two-mass" else loop.T_arm
    if name == "servo":
        # Thesis (9.12), identified on the large robot; 4 ms: the rate of its log.
        return System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], 0.004)  # type: ignore[arg-type]
    if name == "" or not Path(name).exists():
        raise ValueError(f"no model {name!r}: give a JSON file or one of {', '.join(BUILT_IN)}")
    return read_system(check_file(Path(name), LARGEST_MODEL))


def design(*, cfg: DesignCfg = DesignCfg(), common: Common = Common()) -> None:
    """Propose gain, shift and cutoff of the heuristic law for a model of T_u.

    Writes design.png (criterion, Nyquist view) and summary.json.
    """
    from armside.ilc.analysis.proposal import propose

    from ..figures.design import draw_proposal

    report = Report(common)
    with checking_input():
        model = load(cfg.model)
        lowest = LOWEST * 0.5 / model.sample_time
        if cfg.cutoff < lowest:
            below = f"below which no criterion is evaluated, got {cfg.cutoff:g}"
            raise ValueError(f"cutoff must be >= {lowest:g} Hz, {below}")
        proposal = propose(model, cfg.cutoff, fraction=cfg.share)
    sentence, numbers = proposal.sentence(), {name: getattr(proposal, name) for name in NUMBERS}
    result = {"iterations_to_5_percent": proposal.iterations_to_5_percent, "sentence": sentence}
    outcome = summary("design", cfg, common, design=numbers | result)
    with run_folder(outcome, common) as folder:
        draw_proposal(folder / "design.png", proposal)
    free = "this model would allow learning without Q"
    report.table(f"Design for {cfg.model}", HEADS, [tuple(numbers.values())], missing=free)
    report.line(sentence)
    report.results(outcome, folder.path)
