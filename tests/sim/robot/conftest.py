"""Robots of the thesis, read once; no test changes them."""

import pytest

from armside import assets
from armside.sim.laser import Cut, prepare
from armside.sim.robot.model import load_model


@pytest.fixture(scope="session")
def design():
    """The large robot, without effects."""
    return load_model(assets.LARGE_ROBOT_XML)


@pytest.fixture(scope="session")
def irb1400():
    return load_model(assets.IRB1400_XML)


@pytest.fixture(scope="session")
def reference(design):
    """Motor angles of the default cut."""
    return prepare(Cut(), nominal=design).loaded.reference
