"""The claim of `armside verify laser`: motor-side learning at p1, p2 and p3."""

from collections.abc import Iterable

from armside.sim.calibration import bands
from armside.sim.calibration.bands import POSES
from armside.sim.evaluation.check import Check, Table, held
from armside.sim.laser.specification import Cut
from armside.sim.notes import Tally

from .learned import learned

SHOWN = ("a1", "a3", "a4", "b1", "b6", "b7")
"""Checks of chapter 9 that hold for every robot and noise."""


def laser(seeds: Iterable[int]) -> Table:
    """40 mm/s, gamma 0.9, delta 3, 10 Hz, five updates; one row per seed.

    Each seed is another individual (friction +-2 %), another tracker set-up and other noise.
    """
    by_seed: dict[int, list[Check]] = {}
    rows, said = [], Tally()
    for seed in seeds:
        base = {pose: learned(Cut(pose=pose), seed) for pose in POSES}
        for run in base.values():
            said.add(run.notes)
        found = [*bands.motor_side(base), *bands.arm_side(base)]
        by_seed[seed] = [check for check in found if check.id in SHOWN]
        worst, count, own_worst = (check.ours for check in by_seed[seed][:3])
        ratio = [float(bands.over_first(base[pose])) for pose in POSES]
        rows.append((seed, worst, int(count), own_worst, *ratio))
    title = "Motor-side learning at 40 mm/s: motors and tool after five updates"
    motors = ("worst motor (9.5)", "motors at 0.10 of own k = 0", "worst motor of own k = 0")
    columns = ("seed", *motors, *(f"arm RMS {pose} of its k = 0" for pose in POSES))
    return Table(title, columns, rows, held(by_seed), said.notes("runs"))
