"""The zero pose, motors off and on; averaging the spectrum separates lines from noise."""

from collections.abc import Iterator

import numpy as np

from armside.sim.imu import RestExperiment
from armside.sim.imu.vibration import lines, run_rest
from armside.sim.robot.recording import saturation

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, within
from ._imu import axes, by_axis

OFF, ON, LEVEL = "off RMS", "on RMS", "on 99.7 %"


def run(seed: int, tally: Tally) -> Iterator[Row]:
    result = run_rest(RestExperiment(off=10.0, on=20.0), seed)
    tally.add(saturation(result.run.recording))
    found = result.rest
    vibration = by_axis(OFF, found.off_rms) | by_axis(ON, found.on_rms)
    spectrum = {"_frequency": found.frequency, "_spectrum": found.on_spectrum[:, 1]}
    yield {"seed": seed} | vibration | by_axis(LEVEL, found.on_level) | spectrum


def checks(rows: Rows) -> Iterator[Check]:
    off, on, level = (rows.of(*axes(name)) for name in (OFF, ON, LEVEL))
    frequency, density = rows["_frequency"][0], np.mean(rows["_spectrum"], axis=0)
    near_27 = max((h for f, h in lines(frequency, density) if 25.0 < f < 30.0), default=0.0)
    quiet, louder = within(off, 0.009, 0.014), on[:, 1:] > 3.0 * off[:, 1:]
    line = "the averaged spectrum has a line at 25 to 30 Hz in y, at least 0.2 of the highest"
    claims = {
        "with motors off the noise is the sensor's, 0.009 to 0.014 m/s^2": quiet,
        "with motors on it is at least three times larger in y and z": bool(louder.all()),
        "and its 99.7 % level is 0.15 to 0.45 m/s^2 there": within(level[:, 1:], 0.15, 0.45),
        line: near_27 >= 0.2,
    }
    yield from (all_hold(statement, holds) for statement, holds in claims.items())


CLAIM = Claim(
    title="Acceleration of the IRB1400 at rest, motors off and on", seeds=10, run=run, checks=checks
)
