"""The claim that the other robot predicts its IMU, too."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from armside.sim.evaluation.check import Table, all_hold

from ..commands.imu import BEST, ImuExperimentCfg, evaluated_again, prepare, run_one

BASE = ImuExperimentCfg(robot="large")
MAPPED = replace(BASE, **BEST)
ACCELERATION, ANGULAR_VELOCITY = 0.15, 0.010
"""Stated RMS [m/s^2], [rad/s]."""


def imu_large(seeds: Iterable[int]) -> Table:
    """The simultaneous motion of the large robot; each seed is another IMU and other noise."""
    moving = prepare(BASE)[0]
    rows = []
    for seed in seeds:
        done = run_one(BASE, moving, seed)
        m, mapped = done.measures, evaluated_again(MAPPED, done)
        rows.append(
            (
                seed,
                1e3 * m.clock_offset_error,
                *map(float, (*m.acceleration_rms, *mapped.acceleration_rms)),
                float(m.angular_velocity_rms.max()),
                float(mapped.angular_velocity_rms.max()),
                1e3 * m.tool_distance,
            )
        )
    numbers = np.array(rows)
    clock, a, omega = numbers[:, 1], numbers[:, 2:8], numbers[:, 8:10]
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
            all_hold(
                f"acceleration is predicted within {ACCELERATION:g} m/s^2 RMS",
                bool((a < ACCELERATION).all()),
            ),
            all_hold(
                f"angular velocity within {ANGULAR_VELOCITY:g} rad/s RMS",
                bool((omega < ANGULAR_VELOCITY).all()),
            ),
            all_hold("clocks are synchronised to 1 ms", bool((np.abs(clock) < 1.0).all())),
        ),
    )
