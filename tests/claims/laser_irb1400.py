"""Motor-side learning on the IRB1400; each seed is another individual, tracker set-up and noise.

`laser-irb1400-design`: designs from learning data. `laser-irb1400-poses`: each seed is another pose
and speed too. The heuristic law has the design of the robot, chosen at p1; the law on the simulated
nominal robot has one chosen of cutoffs 20, 30 and 35 Hz with shifts 8, 7 and 6 at the cuts of seeds
104, 107 to 110 and 112.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.proposal import FAST_ENOUGH
from armside.sim.cell import CELLS
from armside.sim.laser.design import THESIS, Design, default_design
from armside.sim.laser.design_from_data import CUTOFFS, design_from_data
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import iterate
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.results import iteration_row, notes
from armside.sim.laser.specification import Cut

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._learned import POSES, Learned, learned, of_rows
from ._random_cuts import random_cut

ROBOT = "irb1400"
LEARNED = 0.10
NORMS = {"motor_two": "2-norm", "motor_inf": "inf-norm"}
BY_THESIS = tuple(f"design of the thesis, p1: worst {norm}" for norm in NORMS.values())


def run(seed: int, tally: Tally) -> Iterator[Row]:
    runs = {pose: learned(Cut(robot=ROBOT, pose=pose), seed, tally) for pose in POSES}
    by_thesis = learned(Cut(robot=ROBOT), seed, tally, THESIS)
    worst = {
        f"worst {words} {pose}": run.worst(norm)
        for norm, words in NORMS.items()
        for pose, run in runs.items()
    }
    motors = {
        f"inf-norm p1, motor {i}": value
        for i, value in enumerate(runs["p1"].normalised("motor_inf").tolist(), 1)
    }
    arm = {f"arm {p}, k = {k % 6} [um]": run.arm(k) for k in (0, -1) for p, run in runs.items()}
    other = dict(zip(BY_THESIS, map(by_thesis.worst, NORMS), strict=True))
    yield {"seed": seed} | worst | motors | arm | other


def checks(rows: Rows) -> Iterator[Check]:
    ends = f"ends at {LEARNED} or below at every pose, normalised as (9.5)"
    for norm in NORMS.values():
        worst = rows.of(*(f"worst {norm} {pose}" for pose in POSES))
        yield all_hold(f"every motor's {norm} {ends}; worst {worst.max():.3f}", worst <= LEARNED)
    arm_first, arm_last = (rows.of(*(f"arm {p}, k = {k} [um]" for p in POSES)) for k in (0, 5))
    half = "the tool's RMS falls to half or less at every pose, by the tracker"
    yield all_hold(half, arm_last < 0.5 * arm_first)
    ours = rows.of(*(f"worst {norm} p1" for norm in NORMS.values()))
    higher = "with the design of the thesis every seed ends higher in either norm"
    yield all_hold(higher, rows.of(*BY_THESIS) > ours)


CLAIM = Claim(
    title="Motor-side learning on the IRB1400 at 40 mm/s", seeds=20, run=run, checks=checks
)


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


def run_design(seed: int, _: Tally) -> Iterator[Row]:
    yield {"seed": seed} | designed(Cut(robot=ROBOT), seed)


def checks_design(rows: Rows) -> Iterator[Check]:
    ours = default_design(CELLS[ROBOT])
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


CLAIM_DESIGN = Claim(
    title="The design that learning data of the IRB1400 ask for",
    seeds=20,
    run=run_design,
    checks=checks_design,
)


REPEATS = 4
SIMULATED = Design(gamma=(1.0,), delta=(6,), cutoff=(35.0,))
COLUMNS = {
    "seed": "seed",
    "speed": "speed [mm/s]",
    "heuristic": "heuristic law: worst inf-norm, k = 5",
    "first": "simulated: worst inf-norm, k = 1",
    "worst": "k = 5",
    "motor": "its motor",
    "alone": "of a run alone",
    "arm_first": "arm, k = 0 [um]",
    "arm_heuristic": "heuristic, k = 5",
    "arm_simulated": "simulated, k = 5",
}


def run_poses(seed: int, tally: Tally) -> Iterator[Row]:
    cut = random_cut(ROBOT, seed)
    heuristic = learned(cut, seed, tally)
    simulated, alone = on_nominal(cut, seed)
    tally.add(simulated.notes)
    yield {
        "seed": seed,
        "speed": 1e3 * cut.speed,
        "heuristic": heuristic.worst("motor_inf"),
        "first": simulated.worst("motor_inf", 1),
        "worst": simulated.worst("motor_inf"),
        "motor": int(1 + simulated.normalised("motor_inf").argmax()),
        "alone": alone,
        "arm_first": heuristic.arm(0),
        "arm_heuristic": heuristic.arm(-1),
        "arm_simulated": simulated.arm(-1),
    }


def on_nominal(cut: Cut, seed: int) -> tuple[Learned, float]:
    """Measures of learning on the nominal robot, and the part of runs that they do not share.

    The second is the largest departure of a run from the mean of `REPEATS` with the last
    correction, over the largest motor error at k = 0.
    """
    experiment = prepare(cut, seed=seed)
    set_up = MotorAngles(SIMULATED, simulated=True).prepare(experiment)
    iterations = list(iterate(experiment, set_up, 5))
    found = of_rows([iteration_row(one) for one in iterations], notes(experiment, iterations))
    again = (experiment.plant.run(iterations[-1].correction) for _ in range(REPEATS))
    errors = np.array([run.recording.error for run in again])
    departure = np.abs(errors - errors.mean(axis=0)).max(axis=(0, 1))
    unbiased = np.sqrt(REPEATS / (REPEATS - 1.0)) * experiment.loaded.model.drives.gear
    return found, float(np.max(departure * np.abs(unbiased)) / found["motor_inf"][0].max())


def checks_poses(rows: Rows) -> Iterator[Check]:
    heuristic, worst, alone = (rows[name] for name in ("heuristic", "worst", "alone"))
    words = f"learned on the nominal robot, every motor's inf-norm ends at {LEARNED:g} or below, "
    yield all_hold(f"{words}normalised as (9.5); {_words(worst)}", worst <= LEARNED)
    fewer = "every motor's inf-norm falls below that of the worst motor at k = 0"
    yield all_hold(fewer, np.maximum(worst, heuristic) < 1.0)
    below = f"its median is below that of the heuristic law ({_words(heuristic)})"
    yield all_hold(below, np.median(worst) < np.median(heuristic))
    mostly = f"where it ends above {LEARNED:g}, more than half of it is of that run alone"
    yield all_hold(mostly, (worst <= LEARNED) | (alone > 0.5 * worst))


def _words(worst: Array) -> str:
    over = f"{(worst > LEARNED).sum()} of {len(worst)} do not"
    return f"{over}, median {np.median(worst):.3f}, worst {worst.max():.3f}"


CLAIM_POSES = Claim(
    title="Motor-side learning on the IRB1400 at random poses and speeds of 12 to 77 mm/s",
    seeds=20,
    run=run_poses,
    checks=checks_poses,
    columns=COLUMNS,
)
