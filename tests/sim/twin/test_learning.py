"""Individuals that run beside each other are those that run alone."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.evaluation.tool_error import tool_error
from armside.sim.laser import Cut, prepare
from armside.sim.motion.contour import square
from armside.sim.papers.unseen import line
from armside.sim.robot.effects import gear_phases
from armside.sim.robot.individual import Individual
from armside.sim.twin import correction
from armside.sim.twin.identification import parameters_of
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


def largest_deviation(pose):
    """Largest deviation [m] of a square of 20 mm with corners of 3 mm, learned inside a twin."""
    design = design_of("large", None)
    known = parameters_of(design)
    twin = known.individual(known.mean, gear_phases(design.model))
    cut = Cut(pose=pose, contour=square(0.02, 0.003), speed=0.08, friction_spread=0.0)
    experiment = prepare(cut)
    learned, _ = correction.learn_in_twin(design, twin, experiment)
    truth = design.run([twin], experiment.loaded.reference, learned)[0].truth
    every = slice(None, None, round(1e-3 / float(truth.time[1])))
    return tool_error(experiment.motion, truth.time[every], truth.tool_position[every]).maxdev


@pytest.mark.parametrize("pose", ["p1", "p3"])
def test_corners_leave_less_than_twenty_micrometres(pose):
    assert largest_deviation(pose) < 20e-6


def test_a_law_of_ten_hertz_leaves_more_at_corners(monkeypatch):
    wide = largest_deviation("p1")
    monkeypatch.setattr(correction, "CUTOFF", 10.0)
    assert largest_deviation("p1") > 1.5 * wide


def test_a_line_of_eighty_centimetres_is_learned_by_the_responses_along_it():
    """By the response in one place it grows to 8 times what is left without correction."""
    design = design_of("large", None)
    known = parameters_of(design)
    twin = known.individual(known.mean, gear_phases(design.model))
    experiment = prepare(replace(line(0, 0.5), individual=None, friction_spread=0.0))
    _, rms = correction.learn_in_twin(design, twin, experiment)
    assert rms[-1] < 0.05 * rms[0]
