"""Learning without each effect of gears and drives: the default cut at p1 and p3."""

from collections.abc import Iterator

from armside.sim.laser.specification import Cut
from armside.sim.robot.effects import Effect

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, crossed
from ._learned import learned

LEFT_OUT: dict[str, tuple[Effect, ...]] = {
    "nothing": (),
    **{effect.value: (effect,) for effect in Effect},
    "all four": tuple(Effect),
}
POSES = ("p1", "p3")
SMALL = 0.10
WORST = "worst motor at k = 5 over k = 0, both poses"


def run(case: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, name = case
    runs = {p: learned(Cut(pose=p, without=LEFT_OUT[name]), seed, tally) for p in POSES}
    tool = {f"{p}, k = {k % 6}": run.arm(k) for p, run in runs.items() for k in (0, -1)}
    motors = [r["motor_inf"][-1].max() / r["motor_inf"][0].max() for r in runs.values()]
    yield {"seed": seed, "left out": name} | tool | {WORST: float(max(motors))}


def checks(rows: Rows) -> Iterator[Check]:
    p1, p3 = rows["p1, k = 5"], rows["p3, k = 5"]
    better, without = p3 < rows["p3, k = 0"], rows["left out"]
    yield all_hold(
        f"motors learn whatever is left out: at most {SMALL:g} is left of the worst",
        rows[WORST] <= SMALL,
    )
    yield all_hold("the tool is left with more at p3 than at p1, whatever is left out", p3 > p1)
    yield all_hold(
        "with all effects p3 does not get better, without any it does",
        [*~better[without == "nothing"], *better[without == "all four"]],
    )


CLAIM = Claim(
    title="Effects left out: tool RMS before and after five updates [µm]",
    seeds=3,
    cases=crossed(LEFT_OUT),
    run=run,
    checks=checks,
)
