"""The default pass band of `laser --measure estimate` follows the arm; a given one stays."""

import pytest

from armside.scripts.cutting.options import LaserCfg
from armside.scripts.cutting.specification import measure


@pytest.mark.parametrize(
    ("given", "raised"), [({}, True), ({"cutoff": (10.0,)}, True), ({"cutoff": (12.0,)}, False)]
)
def test_a_cutoff_other_than_the_default_is_kept(given, raised):
    law = measure(LaserCfg(robot="irb1400", measure="estimate", **given)).law
    assert law.up_to_mode is raised
    assert law.cutoff == given.get("cutoff", (10.0,))[0]


def test_motors_have_no_pass_band_of_an_arm():
    assert not LaserCfg(robot="irb1400").up_to_mode
