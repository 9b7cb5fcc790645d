"""What a cut is prepared with."""

import pytest

from armside.sim.laser import Cut, prepare


@pytest.mark.parametrize(("known", "added"), [(True, 35.0), (False, 0.0)])
def test_a_controller_that_knows_the_payload_knows_what_it_has_beyond_the_tool_of_40_kg(
    known, added
):
    made = prepare(Cut(payload=75.0, payload_known=known), seed=0)
    assert made.added_payload == pytest.approx(added)
