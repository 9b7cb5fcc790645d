"""Units of an IMU and a tracker that cannot be right are named."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside.sim.gears import GearsCfg, analyse
from armside.sim.recordings import Stream
from armside.sim.recordings.alignment.checks import check_pair

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


@pytest.mark.parametrize("degrees", [30.0, 90.0, 150.0])
def test_sensors_of_one_housing_have_the_same_axes(degrees):
    turned = Rotation.from_rotvec(np.radians([0.0, 0.0, degrees])).as_matrix()
    slightly = Rotation.from_rotvec(np.radians([0.0, 0.0, 3.0])).as_matrix()
    check_pair(np.eye(3), slightly, np.zeros(3))
    with pytest.raises(ValueError, match=f"differ by {degrees:.0f} degrees"):
        check_pair(np.eye(3), turned, np.zeros(3))


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
