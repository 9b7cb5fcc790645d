"""Options of a study in the units of its env."""

import pytest

from armside.scripts.studies.options import TuneCfg


def test_what_is_fixed_for_all_episodes_is_in_metres_and_kilograms():
    assert TuneCfg().fixed == {}
    assert TuneCfg(pose="p1", speed=60.0, payload=40.0).fixed == {
        "pose": "p1",
        "speed": 0.06,
        "payload": 40.0,
    }


@pytest.mark.parametrize(
    ("speed", "allowed"), [(1.0, True), (100.0, True), (0.99, False), (100.1, False)]
)
def test_a_speed_is_from_one_to_a_hundred_millimetres_per_second(speed, allowed):
    if allowed:
        assert TuneCfg(speed=speed).fixed["speed"] == pytest.approx(1e-3 * speed)
    else:
        with pytest.raises(ValueError, match="speed must be from 1 to 100 mm/s"):
            TuneCfg(speed=speed)
