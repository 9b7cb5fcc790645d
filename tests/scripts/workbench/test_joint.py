"""Numbers of the joint of chapter 8 that a person may give."""

import pytest

from armside.ilc.models.two_mass import TwoMassLoop
from armside.scripts.workbench.joint import FACTOR, loop_of


@pytest.mark.parametrize("share", [1.0 / FACTOR, FACTOR])
def test_the_ends_of_what_a_number_may_be_belong_to_it(share):
    known = TwoMassLoop().joint.fm
    assert loop_of([f"fm={known * share!r}"]).joint.fm == known * share
    with pytest.raises(ValueError, match="fm must be"):
        loop_of([f"fm={known * share**1.01!r}"])
