"""Units of a sensor by the scale that fits."""

import numpy as np
import pytest

from armside.sim.recordings.alignment.checks import check_sensor


@pytest.mark.parametrize("share", [0.51, 1.0, 1.99])
@pytest.mark.parametrize(
    ("quantity", "factor", "unit"),
    [
        ("angular rate", 180.0 / np.pi, "degrees per second"),
        ("specific force", 1.0 / 9.81, r"g\?"),
        ("specific force", 1e3, r"mm/s\^2"),
    ],
)
def test_a_scale_within_a_factor_of_two_of_another_unit_names_it(quantity, factor, unit, share):
    with pytest.raises(ValueError, match=f"is it in {unit}"):
        check_sensor(quantity, share * factor * np.eye(3))


def test_a_sensor_may_be_off_by_a_factor_of_two():
    for scale in (0.5, 2.0):
        check_sensor("angular rate", scale * np.eye(3))
    with pytest.raises(ValueError, match="singular values"):
        check_sensor("angular rate", 2.01 * np.eye(3))
