"""The IMU on the large robot, simultaneous motion; each seed is another IMU and other noise."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from armside.sim.imu import notes, prepare, reprocessed, run_one

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._imu import LARGE, axes, by_axis

RMS = "a RMS", " [m/s^2]"
MAPPED = "mapped, then filtered: a RMS", ""
OMEGA = ("omega RMS [rad/s]", "mapped, then filtered: omega RMS")


@cache
def motion() -> Any:
    return prepare(LARGE)[0]


def run(seed: int, tally: Tally) -> Iterator[Row]:
    result = run_one(LARGE, motion(), seed)
    tally.add(notes([result]))
    m, mapped = result.measures, reprocessed(result, LARGE.processing.best).measures
    omega = [float(each.angular_velocity_rms.max()) for each in (m, mapped)]
    yield {
        "seed": seed,
        "clock error [ms]": 1e3 * m.clock_offset_error,
        **by_axis(RMS[0], m.acceleration_rms, RMS[1]),
        **by_axis(MAPPED[0], mapped.acceleration_rms, MAPPED[1]),
        **dict(zip(OMEGA, omega, strict=True)),
        "tool to D-H [mm]": 1e3 * m.tool_distance,
    }


def checks(rows: Rows) -> Iterator[Check]:
    a, omega = rows.of(*axes(*RMS), *axes(*MAPPED)), rows.of(*OMEGA)
    clock = rows["clock error [ms]"]
    yield all_hold("acceleration is predicted within 0.15 m/s^2 RMS", bool((a < 0.15).all()))
    yield all_hold("angular velocity within 0.01 rad/s RMS", bool((omega < 0.010).all()))
    yield all_hold("clocks are synchronised to 1 ms", bool((np.abs(clock) < 1.0).all()))


CLAIM = Claim(
    title="An IMU on the large robot: measured against predicted from motor angles",
    seeds=10,
    run=run,
    checks=checks,
)
