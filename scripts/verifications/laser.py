"""The claim of `armside verify laser`: what motor-side learning does at p1, p2 and p3."""

from collections.abc import Iterable

import numpy as np

from armside.ilc.measures import norms as measures

from ..commands.laser import LaserCfg, run
from ..commands.verify import Table, Verdict

POSES = ("p1", "p2", "p3")
NORMALISED, OWN, OWN_WORST, ENOUGH = 0.10, 0.10, 0.30, 14


def laser(seeds: Iterable[int]) -> Table:
    """40 mm/s, gamma 0.9, delta 3, 10 Hz, five updates; one row per seed.

    Each seed is another individual (friction +-2 %), another tracker set-up and other noise.
    """
    rows = [(seed, *_row(seed)) for seed in seeds]
    worst, count, own_worst, p1, p2, p3 = np.array(rows, dtype=float).T[1:]
    return Table(
        title="Motor-side learning at 40 mm/s: motors and tool after five updates",
        columns=(
            "seed",
            "worst motor (9.5)",
            "motors at 0.10 of own k = 0",
            "worst motor of own k = 0",
            *(f"arm RMS {pose} of its k = 0" for pose in POSES),
        ),
        rows=rows,
        verdicts=(
            Verdict(
                f"every motor at every pose ends at {NORMALISED} or below, normalised as (9.5)",
                bool((worst <= NORMALISED).all()),
            ),
            Verdict(
                f"of its own k = 0, at least {ENOUGH} of 18 motors end at {OWN} or below",
                bool((count >= ENOUGH).all()),
            ),
            Verdict(
                f"of its own k = 0, no motor ends above {OWN_WORST}",
                bool((own_worst <= OWN_WORST).all()),
            ),
            Verdict("the tool's RMS at p1 falls to half or less", bool((p1 <= 0.5).all())),
            Verdict("the RMS ratios are ordered p1 < p2 < p3", bool(((p1 < p2) & (p2 < p3)).all())),
        ),
    )


def _row(seed: int) -> tuple[float, int, float, float, float, float]:
    runs = [run(LaserCfg(pose=pose), seed)["iterations"] for pose in POSES]
    first, last = (np.array([r[k]["motor_inf"] for r in runs]) for k in (0, -1))
    own = last / first
    ratio = [r[-1]["arm_rms"] / r[0]["arm_rms"] for r in runs]
    worst = measures.normalise(last, first).max()
    return float(worst), int((own <= OWN).sum()), float(own.max()), *ratio
