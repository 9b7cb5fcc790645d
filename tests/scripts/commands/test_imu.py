"""Ends of the options of `armside imu`."""

import pytest

from armside.scripts.commands.imu import AT_MOST


@pytest.mark.parametrize("name", ["off", "on"])
def test_a_rest_lasts_up_to_ten_minutes(name):
    AT_MOST[name].check(name, (0.001, 600.0))
    for seconds in (0.0, 600.1):
        with pytest.raises(ValueError, match="600] s"):
            AT_MOST[name].check(name, seconds)
