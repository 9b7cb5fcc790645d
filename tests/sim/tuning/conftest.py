"""Envs of one job that is quick to run: 60 mm/s at p1."""

import pytest

QUICK = {"pose": "p1", "speed": 0.060, "payload": 40.0}


@pytest.fixture(scope="session")
def quick():
    return QUICK
