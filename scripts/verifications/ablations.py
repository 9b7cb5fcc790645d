"""The claim of `armside verify ablations`: learning without each effect of gears and drives."""

from collections.abc import Iterable

from armside.sim.evaluation.check import Table, all_hold
from armside.sim.laser.specification import Cut
from armside.sim.notes import Tally
from armside.sim.robot.effects import Effect

from .learned import learned

LEFT_OUT: dict[str, tuple[Effect, ...]] = {
    "nothing": (),
    **{effect.value: (effect,) for effect in Effect},
    "all four": tuple(Effect),
}
POSES = ("p1", "p3")
SMALL = 0.10


def ablations(seeds: Iterable[int]) -> Table:
    """The default cut at p1 and p3 with all effects, without each, and without any."""
    said = Tally()
    rows = [_row(seed, name, said) for seed in seeds for name in LEFT_OUT]
    title = "Effects left out: tool RMS before and after five updates [µm]"
    columns = ("seed", "left out", "p1, k = 0", "p1, k = 5", "p3, k = 0", "p3, k = 5")
    worst = "worst motor at k = 5 over k = 0, both poses"
    statements = {
        f"motors learn whatever is left out: at most {SMALL:g} is left of the worst": [
            row[-1] <= SMALL for row in rows
        ],
        "the tool is left with more at p3 than at p1, whatever is left out": [
            row[5] > row[3] for row in rows
        ],
        "with all effects p3 does not get better, without any it does": [
            *(row[5] > row[4] for row in rows if row[1] == "nothing"),
            *(row[5] < row[4] for row in rows if row[1] == "all four"),
        ],
    }
    verdicts = [all_hold(*each) for each in statements.items()]
    return Table(title, (*columns, worst), rows, verdicts, said.notes("runs"))


def _row(seed: int, name: str, said: Tally) -> tuple:
    runs = [learned(Cut(pose=pose, without=LEFT_OUT[name]), seed) for pose in POSES]
    for run in runs:
        said.add(run.notes)
    rms = (1e6 * float(run["arm_rms"][k]) for run in runs for k in (0, -1))
    motors = (float(run["motor_inf"][-1].max() / run["motor_inf"][0].max()) for run in runs)
    return (seed, name, *rms, max(motors))
