"""Errors of the nominal robot, which a law simulates between runs."""

import numpy as np

from armside import assets
from armside.sim.laser import Cut, prepare
from armside.sim.laser.design import default_design
from armside.sim.laser.measures import _on_nominal

CUT = Cut(robot=str(assets.LARGE_ROBOT_XML.with_name("two_link.toml")))


def test_a_simulated_error_is_the_target_less_what_the_nominal_motors_do():
    """It grows by what is added to the target alone, and is that of a servo: below 0.1 rad."""
    experiment, law = prepare(CUT, seed=0), default_design(CUT.cell).law
    reference = experiment.loaded.reference
    zero = np.zeros_like(reference)
    error, shifted = (
        _on_nominal(experiment, reference + shift, law).simulation(zero) for shift in (0.0, 0.25)
    )
    assert 0.0 < np.abs(error).max() < 0.1
    np.testing.assert_allclose(shifted - error, 0.25, atol=1e-12)
