"""Claims about learning on the IRB1400, and about its design."""

from collections.abc import Iterable, Mapping

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.proposal import FAST_ENOUGH
from armside.ilc.measures import norms as measures
from armside.sim.evaluation.check import Table, all_hold
from armside.sim.laser.design import DEFAULT_DESIGN, THESIS
from armside.sim.laser.design_from_data import CUTOFFS, design_from_data
from armside.sim.laser.specification import Cut
from armside.sim.notes import Tally

from .learned import learned

ROBOT = "irb1400"
POSES = ("p1", "p2", "p3")
LEARNED = 0.10
NORMS = {"motor_two": "2-norm", "motor_inf": "inf-norm"}


def laser(seeds: Iterable[int]) -> Table:
    """Motor-side learning; each seed is another individual, tracker set-up and noise."""
    said = Tally()
    rows = [(seed, *_row(seed, said)) for seed in seeds]
    numbers = np.array(rows)
    worst = {"2-norm": numbers[:, 1:4], "inf-norm": numbers[:, 4:7]}
    arm_first, arm_last, by_thesis = numbers[:, 13:16], numbers[:, 16:19], numbers[:, 19:21]
    ends = f"ends at {LEARNED} or below at every pose, normalised as (9.5)"
    half = "the tool's RMS falls to half or less at every pose, by the tracker"
    higher = "with the design of the thesis every seed ends higher in either norm"
    return Table(
        "Motor-side learning on the IRB1400 at 40 mm/s",
        (
            "seed",
            *(f"worst {norm} {pose}" for norm in NORMS.values() for pose in POSES),
            *(f"inf-norm p1, motor {i}" for i in range(1, 7)),
            *(f"arm {pose}, k = {k} [um]" for k in (0, 5) for pose in POSES),
            *(f"design of the thesis, p1: worst {norm}" for norm in NORMS.values()),
        ),
        rows,
        [
            *(
                all_hold(f"every motor's {norm} {ends}; worst {of.max():.3f}", of <= LEARNED)
                for norm, of in worst.items()
            ),
            all_hold(half, arm_last < 0.5 * arm_first),
            all_hold(higher, by_thesis > numbers[:, [1, 4]]),
        ],
        said.notes("runs"),
    )


def _row(seed: int, said: Tally) -> list[float]:
    runs = [learned(Cut(robot=ROBOT, pose=pose), seed) for pose in POSES]
    by_thesis = learned(Cut(robot=ROBOT), seed, THESIS)
    for run in (*runs, by_thesis):
        said.add(run.notes)
    return [
        *(float(_normalised(run, norm).max()) for norm in NORMS for run in runs),
        *_normalised(runs[0], "motor_inf").tolist(),
        *(1e6 * float(run["arm_rms"][k]) for k in (0, -1) for run in runs),
        *(float(_normalised(by_thesis, norm).max()) for norm in NORMS),
    ]


def _normalised(run: Mapping[str, Array], norm: str) -> Array:
    """(6,) after the last iteration, over the largest of all motors at k = 0. Thesis (9.5)."""
    return measures.normalise(run[norm][-1], run[norm][0])


def design(seeds: Iterable[int]) -> Table:
    """Designs from learning data of the robot; each seed is another individual and noise."""
    rows = []
    for seed in seeds:
        asked = design_from_data(Cut(robot=ROBOT), seed)
        m, p = asked.model, asked.proposal
        model = (m.delay, m.pole, m.static_gain, float(m.fit))
        rows.append((seed, *model, p.gamma, p.delta, p.cutoff, p.contraction))
    gamma, delta, cutoff = np.array(rows).T[5:8]
    ours = DEFAULT_DESIGN[ROBOT]
    offered = ", ".join(f"{cutoff:g}" for cutoff in CUTOFFS)
    highest = (
        f"of {offered} Hz, {ours.cutoff[0]:g} is the highest cutoff that contracts by "
        f"{FAST_ENOUGH:g} in the median: the default"
    )
    shift = f"the median shift is the default's {ours.delta[0]}"
    gain = f"every gain is within 0.05 of the default's {ours.gamma[0]:g}"
    columns = ("seed", "delay [samples]", "pole", "static gain", "fit")
    return Table(
        "The design that learning data of the IRB1400 ask for",
        (*columns, "gamma", "delta", "cutoff [Hz]", "contraction"),
        rows,
        [
            all_hold(highest, np.median(cutoff) == ours.cutoff[0]),
            all_hold(shift, np.median(delta) == ours.delta[0]),
            all_hold(gain, np.abs(gamma - ours.gamma[0]) <= 0.05),
        ],
    )
