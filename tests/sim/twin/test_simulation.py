"""Individuals that run beside each other are those that run alone."""

import numpy as np

from armside.sim.laser import Cut, prepare
from armside.sim.robot.individual import Individual
from armside.sim.twin.simulation import design_of


def test_what_the_controller_computes_once_serves_every_individual():
    """Bit for bit: its feedforward knows the nominal robot alone."""
    design = design_of("large", None)
    reference = prepare(Cut(speed=0.08, friction_spread=0.0)).loaded.reference
    zero = np.zeros_like(reference)
    individuals = [Individual(), Individual(mass=np.full(6, 1.02), friction=np.full(6, 1.1))]
    together = design.run(individuals, reference, zero)
    for individual, run in zip(individuals, together, strict=True):
        (alone,) = design.run([individual], reference, zero)
        assert np.array_equal(run.motor_torque, alone.motor_torque)
        assert np.array_equal(run.truth.tool_position, alone.truth.tool_position)
    first, second = together
    assert not np.array_equal(first.motor_torque, second.motor_torque)
