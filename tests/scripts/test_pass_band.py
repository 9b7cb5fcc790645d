"""The default pass band of `laser --measure estimate` follows the arm; a given one stays."""

import pytest

from armside.scripts.cutting.options import LaserCfg
from armside.scripts.cutting.specification import measure


@pytest.mark.parametrize(
    ("given", "cutoff"), [({}, None), ({"cutoff": (13.0,)}, None), ({"cutoff": (10.0,)}, 10.0)]
)
def test_a_cutoff_other_than_the_default_is_kept(given, cutoff):
    law = measure(LaserCfg(robot="irb1400", measure="estimate", **given)).law
    assert law.cutoff == cutoff


def test_motors_have_no_pass_band_of_an_arm():
    assert not LaserCfg(robot="irb1400").up_to_mode
