"""Claim about the prediction of an IMU on the large robot."""

from collections.abc import Iterable

import numpy as np

from armside.sim.evaluation.check import Table
from armside.sim.imu import ImuExperiment, prepare, reprocessed, run_one
from armside.sim.imu import experiment as notes
from armside.sim.notes import Tally

from .irb1400 import by_axis, numbers, table

EXPERIMENT = ImuExperiment(robot="large")


def imu_large(seeds: Iterable[int]) -> Table:
    """The simultaneous motion of the large robot; each seed is another IMU and other noise."""
    moving, rows, said = prepare(EXPERIMENT)[0], [], Tally()
    for seed in seeds:
        result = run_one(EXPERIMENT, moving, seed)
        said.add(notes([result]))
        m, mapped = result.measures, reprocessed(result, EXPERIMENT.processing.best).measures
        rows.append(
            {
                "seed": seed,
                "clock error [ms]": 1e3 * m.clock_offset_error,
                **by_axis("a RMS", m.acceleration_rms),
                **by_axis("mapped, then filtered: a RMS", mapped.acceleration_rms, ""),
                "omega RMS [rad/s]": float(m.angular_velocity_rms.max()),
                "mapped, then filtered: omega RMS": float(mapped.angular_velocity_rms.max()),
                "tool to D-H [mm]": 1e3 * m.tool_distance,
            }
        )
    found = numbers(rows)
    claims = {
        "acceleration is predicted within 0.15 m/s^2 RMS": (found[:, 1:7] < 0.15).all(),
        "angular velocity within 0.01 rad/s RMS": (found[:, 7:9] < 0.010).all(),
        "clocks are synchronised to 1 ms": (np.abs(found[:, 0]) < 1.0).all(),
    }
    title = "An IMU on the large robot: measured against predicted from motor angles"
    return table(title, rows, claims, said.notes("runs"))
