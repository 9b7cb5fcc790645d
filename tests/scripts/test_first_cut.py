"""The line about a first cut by a twin."""

from armside.scripts.cutting.first_cut import line


def test_an_interval_that_fewer_errors_hold_says_so():
    found = {"arm_rms": 2e-6, "interval": [1e-6, 3e-6], "uncorrected": 1e-4}
    said = [line(found | {"interval_holds": holds}, [{"arm_rms": None}]) for holds in (True, False)]
    assert said[0].endswith("1.0 to 3.0 um (90 %)")
    assert said[1].endswith("1.0 to 3.0 um (fewer than 90 % by a twin of an IMU)")
