"""Statics of a robot model: one object per model in a run, and the smoothed elastic shift."""

import numpy as np
import pytest

from armside.sim.cell import LARGE_CELL
from armside.sim.laser import Cut, prepare
from armside.sim.robot.model import load_model
from armside.sim.robot.statics import Statics, smoothed


def test_a_run_builds_the_statics_of_each_model_once(monkeypatch):
    models, build = [], Statics.__init__
    monkeypatch.setattr(Statics, "__init__", lambda self, m: (models.append(m), build(self, m))[1])
    nominal = load_model(LARGE_CELL.xml)
    experiment = prepare(Cut(), nominal=nominal)
    experiment.plant.run(np.zeros_like(experiment.loaded.reference))
    # Controller, robot without friction of its own, individual.
    assert len(models) == len({id(model) for model in models}) == 3
    assert models[0] is nominal


def test_shared_statics_give_the_same_bits_as_new_ones():
    model = load_model(LARGE_CELL.xml)
    phi = np.cumsum(np.full((20, 6), 1e-3), axis=0)
    shared = Statics(model)
    first = shared.rigid_forces(phi, phi, phi)
    shared.deflection(phi, first)
    shared.equilibrium(phi[-1])
    assert np.array_equal(shared.rigid_forces(phi, phi, phi), first)
    assert np.array_equal(shared.equilibrium(phi[0]).qpos, Statics(model).equilibrium(phi[0]).qpos)


def test_a_smoothed_shift_keeps_ends_and_mean_and_has_no_steps():
    step = np.repeat([[0.0, 0.0, 1.0], [1.0, 0.0, 3.0]], 50, axis=0)
    smooth = smoothed(step)
    assert smooth.shape == step.shape
    np.testing.assert_allclose(smooth[[0, -1]], step[[0, -1]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(smooth.mean(axis=0), step.mean(axis=0), rtol=1e-12)
    assert np.abs(np.diff(smooth[:, 0])).max() == pytest.approx(1 / 5)
