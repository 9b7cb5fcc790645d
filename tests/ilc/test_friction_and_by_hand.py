"""Dry friction in the two-mass joint, and learning by hand from recorded logs."""

import numpy as np
import pytest

from armside.ilc import Heuristic, ZeroPhaseButterworth, learn
from armside.ilc.by_hand import ByHand
from armside.ilc.laws.first_order import PType
from armside.ilc.laws.memory import HighOrder
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.two_mass import ArmReading, FrictionPlant, TwoMassLoop, TwoMassPlant

LAW = Heuristic(Q=ZeroPhaseButterworth(17.0, 0.01), gamma=0.9, delta=5)


def test_without_friction_and_noise_the_joint_is_the_linear_one():
    linear = TwoMassPlant(loop=TwoMassLoop(arm_reading=ArmReading.STATE))
    u = np.random.default_rng(0).normal(0, 0.1, (800, 1))
    ours, theirs = FrictionPlant().run(u), linear.run(u)
    np.testing.assert_allclose(ours.motor, theirs.motor, atol=1e-7)
    np.testing.assert_allclose(ours.arm, theirs.arm, atol=1e-7)


def test_a_motor_below_its_breakaway_torque_does_not_move():
    asked = np.full((800, 1), 1e-3)
    still = FrictionPlant(arm_reference=0 * asked, coulomb=0.01)
    assert np.abs(still.run(asked).motor).max() < 1e-12
    assert np.abs(FrictionPlant(arm_reference=0 * asked).run(asked).motor).max() > 5e-4


def test_the_simulation_converges_with_its_step():
    runs = [
        FrictionPlant(coulomb=0.1, substeps=n).run(np.zeros((800, 1))).motor for n in (10, 40, 160)
    ]
    coarse, fine = (np.abs(run - runs[-1]).max() for run in runs[:-1])
    assert fine < 0.5 * coarse < 0.01


@pytest.mark.parametrize("coulomb", [0.05, 0.2])
def test_learning_removes_most_of_the_error_of_friction(coulomb):
    plant = FrictionPlant(coulomb=coulomb)
    trials = list(learn(plant, LAW, plant.motor_reference, 20, output_of=lambda run: run.motor))
    norms = [two_norm(trial.error)[0] for trial in trials]
    frictionless = FrictionPlant()
    first = two_norm(
        frictionless.motor_reference - frictionless.run(0 * plant.motor_reference).motor
    )
    assert norms[0] > 1.1 * first[0]  # friction makes the first run worse
    assert norms[20] < 0.05 * norms[0]


def test_noise_sets_a_floor_that_is_seen_on_the_motor_side():
    def last(noise):
        plant = FrictionPlant(coulomb=0.05, noise=noise, rng=np.random.default_rng(0))
        *_, trial = learn(plant, LAW, plant.motor_reference, 20, output_of=lambda run: run.motor)
        return two_norm(trial.error)[0]

    assert last(0.01) > np.sqrt(800) * 0.01 > last(0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"coulomb": -1.0}, "coulomb must be"),
        ({"noise": 1.0}, "needs an rng"),
        ({"substeps": 0}, "substeps"),
    ],
)
def test_impossible_friction_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        FrictionPlant(**change)


# By hand


@pytest.mark.parametrize(
    "law",
    [LAW, HighOrder(alpha=(0.7, 0.3), beta=(0.5, 0.2), L=PType(gamma=1.0, delta=5), Q=LAW.Q)],
    ids=["first order", "with memory"],
)
def test_learning_by_hand_is_the_loop_carried_in_pieces(law, tmp_path):
    plant = TwoMassPlant()
    r = plant.motor_reference
    expected = list(learn(plant, law, r, 3, output_of=lambda run: run.motor))
    state = ByHand(law=law, reference=r)
    for trial in expected:
        assert state.k == trial.k
        np.testing.assert_array_equal(state.correction, trial.correction)
        state = state.record(plant.run(state.correction).motor)
        state.save(tmp_path / "learning.npz")  # and continue another day
        state = ByHand.load(tmp_path / "learning.npz", law)
    assert len(state.errors) == 4
    assert state.table().splitlines()[0].split() == ["k", "two-norm", "largest"]


def test_a_log_that_does_not_fit_is_refused(tmp_path):
    state = ByHand(law=LAW, reference=np.zeros((50, 2)))
    with pytest.raises(ValueError, match="output must have shape"):
        state.record(np.zeros((49, 2)))
    with pytest.raises(ValueError, match="output must be finite"):
        state.record(np.full((50, 2), np.nan))
    np.savez(tmp_path / "other.npz", reference=np.zeros((5, 1)))
    with pytest.raises(ValueError, match="lacks corrections, outputs"):
        ByHand.load(tmp_path / "other.npz", LAW)
