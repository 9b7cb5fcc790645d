"""The cut that estimators are tried on."""

import pytest

from armside.sim.laser import prepare
from armside.sim.laser.loop import first_run

from .one_cut import CUT


@pytest.fixture(scope="session")
def first():
    """One cut before learning."""
    return first_run(prepare(CUT))
