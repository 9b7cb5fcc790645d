"""Units of an IMU and a tracker that cannot be right are named."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.gears import GearsCfg, analyse
from armside.sim.measured import Stream

FACTORS = {
    "degrees per second": ("imu", np.r_[np.ones(3), np.full(3, 180.0 / np.pi)]),
    "in g": ("imu", np.r_[np.full(3, 1.0 / 9.81), np.ones(3)]),
    "millimetres": ("tracker", np.full(3, 1e3)),
}


@pytest.mark.parametrize("unit", FACTORS)
def test_wrong_units_are_named(recordings, scenes, unit):
    sensor, factor = FACTORS[unit]
    stream = getattr(recordings[0], sensor)
    wrong = replace(recordings[0], **{sensor: Stream(stream.time, factor * stream.values)})
    with pytest.raises(ValueError, match=f"scene 1: .*{unit}"):
        analyse(scenes.ARM, [wrong])


def test_a_sensor_of_another_motion_is_refused(recordings, scenes):
    noise = np.random.default_rng(0).normal(size=recordings[0].imu.values.shape)
    other = replace(recordings[0], imu=Stream(recordings[0].imu.time, noise))
    with pytest.raises(ValueError, match="did not see the same motion"):
        analyse(scenes.ARM, [other])


def test_a_recording_without_sensor_is_refused(recordings, scenes):
    bare = replace(recordings[0], imu=None, tracker=None)
    with pytest.raises(ValueError, match="imu or tracker"):
        analyse(scenes.ARM, [recordings[0], bare])
    with pytest.raises(ValueError, match="every recording: tracker"):
        analyse(scenes.ARM, [bare], GearsCfg(sensor="tracker"))
