"""Motor-side learning on the IRB1400; each seed is another individual, tracker set-up and noise."""

from collections.abc import Iterator

from armside.sim.laser.design import THESIS
from armside.sim.laser.specification import Cut

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._learned import POSES, learned

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
