"""The acceleration error of the IMU with each of its causes switched on or off, mean over seeds."""

from collections.abc import Iterator

import numpy as np

from armside.sim.imu import causes, notes

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._imu import BASE, by_axis

MEASURES = ("acceleration_rms", "acceleration_window_max", "angular_velocity_rms")


def run(seed: int, tally: Tally) -> Iterator[Row]:
    for cause, found in causes(BASE, seed, lambda run: tally.add(notes([run]))):
        yield {"cause": cause} | {name: getattr(found, name) for name in MEASURES}


def shown(rows: Rows) -> Iterator[Row]:
    for cause, of_cause in rows.by("cause").items():
        a, window, omega = (np.mean(of_cause[name], axis=0) for name in MEASURES)
        errors = by_axis("a RMS", a) | by_axis("a window", window)
        yield {"": cause} | errors | by_axis("omega RMS", omega, " [rad/s]")


def checks(rows: Rows) -> Iterator[Check]:
    total = {
        cause: float(np.linalg.norm(np.mean(of_cause["acceleration_rms"], axis=0)))
        for cause, of_cause in rows.by("cause").items()
    }
    chosen, rigid = total["as chosen"], total["rigid robot, both"]
    mapped, third = total["mapped, then filtered"], total["both"] / 3
    claims = {
        "delays of the sensors left in raise the error": total["sensor delays left in"] > chosen,
        "filtering the predicted motion, not the joint rates, lowers it": mapped < chosen,
        "central differences lower it": total["central differences"] < chosen,
        "rigid, the robot has less than a third of the error, processed alike": rigid < third,
    }
    yield from (all_hold(statement, holds) for statement, holds in claims.items())


CLAIM = Claim(
    title="Causes of the acceleration error", seeds=5, run=run, checks=checks, shown=shown
)
