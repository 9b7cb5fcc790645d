"""Models of the IRB1400, parsed once for all tests of the robots."""

import pytest

from armside import assets
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.model import load_model


@pytest.fixture(scope="session")
def full():
    """The model as it is."""
    return load_model(assets.IRB1400_XML)


@pytest.fixture(scope="session")
def rigid():
    """The model without elasticity."""
    return load_model(variant(assets.IRB1400_XML, Flexibility.RIGID))
