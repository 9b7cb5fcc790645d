"""Statics of a robot model: one object per model in a run, and the smoothed elastic shift."""

import copy

import mujoco
import numpy as np
import pytest

from armside.sim.cell import CELLS, LARGE_CELL
from armside.sim.laser import Cut, prepare
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.linkage import Linkage, passive_joints
from armside.sim.robot.model import load_model
from armside.sim.robot.statics import Statics, natural_frequencies, smoothed


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


PHI = np.deg2rad([10.0, 20.0, -15.0, 30.0, 40.0, -50.0])
ROUNDING = 1e-6
"""Relative, of difference quotients with a step of 1e-4 rad."""
SOFTNESS = 1e-4
"""Of the constraints that hold a closed chain, the least that MuJoCo takes. Its frequencies are 18
times that too high, relatively, and ten times as much with ten times the softness."""


@pytest.fixture(scope="module", params=CELLS)
def model(request):
    return load_model(CELLS[request.param].xml)


def test_they_are_those_of_the_accelerations_that_mujoco_computes(model):
    """d qacc / d q about rest, without gravity, damping and drives, has eigenvalues -omega^2.

    The tendon is the balancing cylinder's, whose force changes with the pose as gravity's does.
    """
    mj, data = copy.copy(model.mj), mujoco.MjData(model.mj)
    off = mujoco.mjtDisableBit
    mj.opt.disableflags |= int(off.mjDSBL_GRAVITY | off.mjDSBL_DAMPER | off.mjDSBL_ACTUATION)
    mj.tendon_stiffness[:], mj.eq_solimp[:, :2] = 0.0, 1.0 - SOFTNESS
    mj.opt.tolerance, linkage = 0.0, Linkage(mj)
    passive = [] if linkage.is_open else passive_joints(mj)
    free, step = np.setdiff1d(np.arange(mj.nv), passive), 1e-4
    slope = np.empty((len(free), len(free)))
    for column, j in enumerate(free):
        ends = np.empty((2, mj.nv))
        for end, sign in zip(ends, (-1.0, 1.0), strict=True):
            data.qpos[:] = model.posture @ PHI
            data.qpos[j] += sign * step
            linkage.close(data)
            mujoco.mj_forward(mj, data)
            end[:] = data.qacc
        slope[:, column] = (ends[1] - ends[0])[free] / (2.0 * step)
    omega = np.sqrt(np.sort(-np.linalg.eigvals(slope).real)[6:])
    found = natural_frequencies(model, PHI, locked=False)[6:]
    assert found == pytest.approx(
        omega / (2.0 * np.pi), rel=ROUNDING if linkage.is_open else 25.0 * SOFTNESS
    )


def test_free_motors_turn_without_a_spring_and_locked_ones_make_every_mode_lower(model):
    locked = natural_frequencies(model, PHI, locked=True)
    free = natural_frequencies(model, PHI, locked=False)
    assert len(free) == len(locked) + 6
    assert free[:6].max() < 1e-2
    assert free[6] > 1.0
    # A held inertia is an infinite one: Cauchy's interlacing.
    assert (locked <= free[6:] * (1.0 + 1e-9)).all()


def test_springs_four_times_as_stiff_double_them():
    def modes(factor):
        mj = variant(CELLS["irb1400"].xml, gear_stiffness=factor, structure_stiffness=factor)
        return natural_frequencies(load_model(mj), PHI, locked=True)

    assert modes(4.0) == pytest.approx(2.0 * modes(1.0), rel=1e-9)


def test_a_rigid_robot_has_none():
    rigid = load_model(variant(CELLS["irb1400"].xml, Flexibility.RIGID))
    assert len(natural_frequencies(rigid, PHI, locked=True)) == 0
