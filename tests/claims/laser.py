"""Motor-side learning at p1, p2 and p3: 40 mm/s, gamma 0.9, delta 3, 10 Hz, five updates.

Each seed is another individual (friction +-2 %), another tracker set-up and other noise.
"""

from collections.abc import Iterator

from armside.scripts.thesis.chapter9 import bands
from armside.scripts.thesis.chapter9.bands import POSES
from armside.sim.laser.specification import Cut

from ._engine import Check, Claim, Row, Rows, Tally
from ._learned import learned
from ._seeds import held

SHOWN = ("a1", "a3", "a4", "b1", "b6", "b7")
"""Checks of chapter 9 that hold for every robot and noise."""
MOTORS = ("worst motor (9.5)", "motors at 0.10 of own k = 0", "worst motor of own k = 0")


def run(seed: int, tally: Tally) -> Iterator[Row]:
    base = {pose: learned(Cut(pose=pose), seed, tally) for pose in POSES}
    found = [*bands.motor_side(base), *bands.arm_side(base)]
    shown = [check for check in found if check.id in SHOWN]
    worst, count, own_worst = (check.ours for check in shown[:3])
    motors = dict(zip(MOTORS, (worst, int(count), own_worst), strict=True))
    ratio = {f"arm RMS {p} of its k = 0": float(bands.over_first(base[p])) for p in POSES}
    yield {"seed": seed} | motors | ratio | {"_checks": shown}


def checks(rows: Rows) -> list[Check]:
    return held({row["seed"]: row["_checks"] for row in rows})


CLAIM = Claim(
    title="Motor-side learning at 40 mm/s: motors and tool after five updates",
    seeds=20,
    run=run,
    checks=checks,
)
