"""Claims about what the IRB1400 learns, and about the design it learns with."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from armside.ilc.analysis.proposal import FAST_ENOUGH
from armside.ilc.measures import norms as measures

from ..commands.laser import LaserCfg, run
from ..commands.verify import Table, Verdict
from ..laser_options import OF_ROBOT, THESIS
from ..robot_design import CUTOFFS, asked_for

ROBOT = "irb1400"
POSES = ("p1", "p2", "p3")
LEARNED = 0.10
NORMS = {"motor_two": "2-norm", "motor_inf": "inf-norm"}


def laser(seeds: Iterable[int]) -> Table:
    """Motor-side learning; each seed is another individual, tracker set-up and noise."""
    rows = [(seed, *_row(seed)) for seed in seeds]
    numbers = np.array(rows)
    two, inf = numbers[:, 1:4], numbers[:, 4:7]
    arm_first, arm_last = numbers[:, 13:16], numbers[:, 16:19]
    by_thesis = numbers[:, 19:21]
    return Table(
        title="Motor-side learning on the IRB1400 at 40 mm/s",
        columns=(
            "seed",
            *(f"worst {norm} {pose}" for norm in NORMS.values() for pose in POSES),
            *(f"inf-norm p1, motor {i}" for i in range(1, 7)),
            *(f"arm {pose}, k = {k} [um]" for k in (0, 5) for pose in POSES),
            *(f"design of the thesis, p1: worst {norm}" for norm in NORMS.values()),
        ),
        rows=rows,
        verdicts=(
            *(
                Verdict(
                    f"every motor's {norm} ends at {LEARNED} or below at every pose, normalised as "
                    f"(9.5); worst {values.max():.3f}",
                    bool((values <= LEARNED).all()),
                )
                for norm, values in zip(NORMS.values(), (two, inf), strict=True)
            ),
            Verdict(
                "the tool's RMS falls to half or less at every pose, by the tracker",
                bool((arm_last < 0.5 * arm_first).all()),
            ),
            Verdict(
                "with the design of the thesis every seed ends higher in either norm",
                bool((by_thesis > numbers[:, [1, 4]]).all()),
            ),
        ),
    )


def _row(seed: int) -> list[float]:
    runs = [run(LaserCfg(robot=ROBOT, pose=pose), seed)["iterations"] for pose in POSES]
    plain = run(LaserCfg(robot=ROBOT, **THESIS._asdict()), seed)["iterations"]
    worst = [float(_normalised(its, norm).max()) for norm in NORMS for its in runs]
    arm = [1e6 * its[k]["arm_rms"] for k in (0, -1) for its in runs]
    by_thesis = [float(_normalised(plain, norm).max()) for norm in NORMS]
    return [*worst, *map(float, _normalised(runs[0], "motor_inf")), *arm, *by_thesis]


def _normalised(iterations: list[dict[str, Any]], norm: str) -> np.ndarray:
    """(6,) after the last iteration, over the largest of all motors at k = 0. Thesis (9.5)."""
    first, last = (np.array(iterations[k][norm]) for k in (0, -1))
    return measures.normalise(last, first)


def design(seeds: Iterable[int]) -> Table:
    """What learning data of the robot ask for; each seed is another individual and noise."""
    rows = []
    for seed in seeds:
        asked = asked_for(LaserCfg(robot=ROBOT), seed)
        model, proposal = asked.model, asked.proposal
        rows.append(
            (
                seed,
                model.delay,
                model.pole,
                model.static_gain,
                float(model.fit),
                proposal.gamma,
                proposal.delta,
                proposal.cutoff,
                proposal.contraction,
            )
        )
    gamma, delta, cutoff = np.array(rows).T[5:8]
    ours = OF_ROBOT[ROBOT]
    offered = ", ".join(f"{cutoff:g}" for cutoff in CUTOFFS)
    return Table(
        title="The design that learning data of the IRB1400 ask for",
        columns=(
            "seed",
            "delay [samples]",
            "pole",
            "static gain",
            "fit",
            "gamma",
            "delta",
            "cutoff [Hz]",
            "contraction",
        ),
        rows=rows,
        verdicts=(
            Verdict(
                f"of {offered} Hz, {ours.cutoff[0]:g} is the highest cutoff that contracts by "
                f"{FAST_ENOUGH:g} in the median: the default",
                float(np.median(cutoff)) == ours.cutoff[0],
            ),
            Verdict(
                f"the median shift is the default's {ours.delta[0]}",
                float(np.median(delta)) == ours.delta[0],
            ),
            Verdict(
                f"every gain is within 0.05 of the default's {ours.gamma[0]:g}",
                bool((np.abs(gamma - ours.gamma[0]) <= 0.05).all()),
            ),
        ),
    )
