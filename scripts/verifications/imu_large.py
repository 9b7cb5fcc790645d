"""Claim about the prediction of an IMU on the large robot."""

from collections.abc import Iterable

import numpy as np

from armside.sim.imu import ImuExperiment, prepare, reprocessed, run_one

from ..commands.verify import Table, Verdict

EXPERIMENT = ImuExperiment(robot="large")
ACCELERATION, ANGULAR_VELOCITY = 0.15, 0.010
"""Stated RMS [m/s^2], [rad/s]."""


def imu_large(seeds: Iterable[int]) -> Table:
    """The simultaneous motion of the large robot; each seed is another IMU and other noise."""
    moving = prepare(EXPERIMENT)[0]
    rows = []
    for seed in seeds:
        result = run_one(EXPERIMENT, moving, seed)
        m, mapped = result.measures, reprocessed(result, EXPERIMENT.processing.best).measures
        numbers = (
            1e3 * m.clock_offset_error,
            *m.acceleration_rms,
            *mapped.acceleration_rms,
            m.angular_velocity_rms.max(),
            mapped.angular_velocity_rms.max(),
            1e3 * m.tool_distance,
        )
        rows.append((seed, *map(float, numbers)))
    found = np.array(rows)
    clock, a, omega = found[:, 1], found[:, 2:8], found[:, 8:10]
    return Table(
        title="An IMU on the large robot: measured against predicted from motor angles",
        columns=(
            "seed",
            "clock error [ms]",
            *(f"a RMS {axis} [m/s^2]" for axis in "xyz"),
            *(f"mapped, then filtered: a RMS {axis}" for axis in "xyz"),
            "omega RMS [rad/s]",
            "mapped, then filtered: omega RMS",
            "tool to D-H [mm]",
        ),
        rows=rows,
        verdicts=(
            Verdict(
                f"acceleration is predicted within {ACCELERATION:g} m/s^2 RMS",
                bool((a < ACCELERATION).all()),
            ),
            Verdict(
                f"angular velocity within {ANGULAR_VELOCITY:g} rad/s RMS",
                bool((omega < ANGULAR_VELOCITY).all()),
            ),
            Verdict("clocks are synchronised to 1 ms", bool((np.abs(clock) < 1.0).all())),
        ),
    )
