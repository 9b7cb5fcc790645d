"""The claim of `armside verify ablations`: what each effect of the virtual hardware does."""

from collections.abc import Iterable
from typing import get_args

from ..commands.laser import LaserCfg, run
from ..commands.verify import Table, Verdict
from ..laser_options import EffectName

EFFECTS: tuple[EffectName, ...] = get_args(EffectName)
POSES = ("p1", "p3")
SMALL = 0.10


def ablations(seeds: Iterable[int]) -> Table:
    """The default cut at p1 and p3 with all effects, without each, and without any."""
    rows = [row for seed in seeds for row in _rows(seed)]
    return Table(
        title="Effects left out: tool RMS before and after five updates [µm]",
        columns=(
            "seed",
            "left out",
            "p1, k = 0",
            "p1, k = 5",
            "p3, k = 0",
            "p3, k = 5",
            "worst motor at k = 5 over k = 0, both poses",
        ),
        rows=rows,
        verdicts=(
            Verdict(
                f"motors learn whatever is left out: at most {SMALL:g} is left of the worst",
                all(row[-1] <= SMALL for row in rows),
            ),
            Verdict(
                "the tool is left with more at p3 than at p1, whatever is left out",
                all(row[5] > row[3] for row in rows),
            ),
            Verdict(
                "with all effects p3 does not get better, without any it does",
                all(row[5] > row[4] for row in rows if row[1] == "nothing")
                and all(row[5] < row[4] for row in rows if row[1] == "all four"),
            ),
        ),
    )


def _rows(seed: int) -> list[tuple]:
    cases: dict[str, tuple[EffectName, ...]] = {"nothing": ()}
    for name in EFFECTS:
        cases[name] = (name,)
    cases["all four"] = EFFECTS
    return [_row(seed, name, without) for name, without in cases.items()]


def _row(seed: int, name: str, without: tuple[EffectName, ...]) -> tuple:
    rms, motors = [], []
    for pose in POSES:
        rows = run(LaserCfg(pose=pose, without=without), seed)["iterations"]
        rms += [1e6 * rows[0]["arm_rms"], 1e6 * rows[-1]["arm_rms"]]
        motors.append(max(rows[-1]["motor_inf"]) / max(rows[0]["motor_inf"]))
    return (seed, name, *map(float, rms), float(max(motors)))
