"""Runs of an iteration are averaged, and the first run is used once."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.laser import Cut, prepare
from armside.sim.laser.learning import first_run, learned
from armside.sim.laser.measures import MotorAngles


def test_an_iteration_learns_from_the_mean_of_its_runs():
    experiment = prepare(replace(Cut(), friction_spread=0.0))
    first = first_run(experiment)
    runs = []

    class Counted:
        def run(self, correction, /):
            runs.append(experiment.plant.run(correction))
            return runs[-1]

    output = MotorAngles().prepare(experiment)(first)
    zero, one = learned(experiment, output, first, 1, plant=Counted(), repeats=3)
    assert len(runs) == 2 + 3
    reference = experiment.loaded.reference
    angles = [run.recording.motor_angle for run in (first, *runs[:2])]
    assert zero.error == pytest.approx(reference - np.mean(angles, axis=0), abs=1e-15)
    angles = [run.recording.motor_angle for run in runs[2:]]
    assert one.error == pytest.approx(reference - np.mean(angles, axis=0), abs=1e-15)
    assert zero.run is first
