"""Ends of the options of `armside imu`."""

import pytest

from armside.scripts.commands.imu import AT_MOST, ImuOptions
from armside.sim.imu import ImuExperiment


@pytest.mark.parametrize("name", ["off", "on"])
def test_a_rest_lasts_up_to_ten_minutes(name):
    AT_MOST[name].check(name, (0.001, 600.0))
    for seconds in (0.0, 600.1):
        with pytest.raises(ValueError, match="600] s"):
            AT_MOST[name].check(name, seconds)


def test_delays_are_given_in_milliseconds():
    options = ImuOptions(accelerometer_delay=3.0, gyroscope_delay=2.0).experiment()
    assert isinstance(options, ImuExperiment)
    made = options.processing
    assert made.accelerometer_delay == pytest.approx(0.003)
    assert made.gyroscope_delay == pytest.approx(0.002)
