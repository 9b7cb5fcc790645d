"""Designs from learning data of the IRB1400; each seed is another individual and noise."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from armside.ilc.analysis.proposal import FAST_ENOUGH
from armside.sim.laser.design import DEFAULT_DESIGN
from armside.sim.laser.design_from_data import CUTOFFS, design_from_data
from armside.sim.laser.specification import Cut

from ._engine import Check, Claim, Row, Rows, Tally, all_hold

ROBOT = "irb1400"


def designed(cut: Cut, seed: int) -> dict[str, Any]:
    """Cells of the model of a cut's learning data, and of the design that it asks for."""
    asked = design_from_data(cut, seed)
    m, p = asked.model, asked.proposal
    return {
        **{"delay [samples]": m.delay, "pole": m.pole},
        **{"static gain": m.static_gain, "fit": float(m.fit)},
        **{"gamma": p.gamma, "delta": p.delta},
        **{"cutoff [Hz]": p.cutoff, "contraction": p.contraction},
    }


def run(seed: int, _: Tally) -> Iterator[Row]:
    yield {"seed": seed} | designed(Cut(robot=ROBOT), seed)


def checks(rows: Rows) -> Iterator[Check]:
    ours = DEFAULT_DESIGN[ROBOT]
    offered = ", ".join(f"{cutoff:g}" for cutoff in CUTOFFS)
    yield all_hold(
        f"of {offered} Hz, {ours.cutoff[0]:g} is the highest cutoff that contracts by "
        f"{FAST_ENOUGH:g} in the median: the default",
        np.median(rows["cutoff [Hz]"]) == ours.cutoff[0],
    )
    delta = rows["delta"]
    shift = f"the median shift is the default's {ours.delta[0]}"
    yield all_hold(shift, np.median(delta) == ours.delta[0])
    gain = f"every gain is within 0.05 of the default's {ours.gamma[0]:g}"
    yield all_hold(gain, np.abs(rows["gamma"] - ours.gamma[0]) <= 0.05)


CLAIM = Claim(
    title="The design that learning data of the IRB1400 ask for", seeds=20, run=run, checks=checks
)
