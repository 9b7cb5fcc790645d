"""The learning loop, learning by hand, and the joint with friction."""

from dataclasses import FrozenInstanceError, dataclass
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lfilter

from armside.ilc import AllPass, Heuristic, ZeroPhaseButterworth, learn
from armside.ilc.by_hand import ByHand
from armside.ilc.laws.first_order import PType
from armside.ilc.laws.memory import HighOrder
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.two_mass import ArmReading, FrictionPlant, TwoMassLoop, TwoMassPlant

SAMPLE_TIME = 0.004


@dataclass(frozen=True)
class Scaled:
    """y = gain * (r + u)."""

    reference: np.ndarray
    gain: float

    def run(self, correction, /):
        return self.gain * (self.reference + correction)


@dataclass(frozen=True)
class Arx:
    """The identified servo of thesis (9.12), the same for each motor."""

    reference: np.ndarray

    def run(self, correction, /):
        delayed = np.zeros_like(correction)
        delayed[5:] = (self.reference + correction)[:-5]
        return lfilter([0.5083], [1.0, -0.4884], delayed, axis=0)


def moves(n_samples=380, n_motors=6):
    """A smooth move that starts and ends at rest."""
    t = np.linspace(-1.0, 2.0, n_samples).clip(0.0, 1.0)
    shape = t - np.sin(2 * np.pi * t) / (2 * np.pi)
    return shape[:, None] * np.arange(1.0, n_motors + 1)


def test_the_error_of_a_gain_contracts_by_one_minus_gamma_times_gain():
    reference = moves()
    law = Heuristic(Q=AllPass(), gamma=0.9)
    trials = list(learn(Scaled(reference, 0.8), law, reference, 5))
    assert [trial.k for trial in trials] == [0, 1, 2, 3, 4, 5]
    for before, after in pairwise(trials):
        np.testing.assert_allclose(after.error, (1 - 0.9 * 0.8) * before.error, atol=1e-12)


def test_the_error_diverges_if_the_criterion_fails_and_the_loop_reports_it():
    reference = moves()
    law = Heuristic(Q=AllPass(), gamma=2.5)  # |1 - 2.5| > 1 at every frequency
    trials = list(learn(Scaled(reference, 0.9), law, reference, 50))
    assert trials[-1].diverged
    assert not any(trial.diverged for trial in trials[:-1])
    # |1 - 2.25| = 1.25 per iteration passes three times the first error at k = 5
    assert trials[-1].k == 5


def test_a_value_that_is_not_finite_ends_the_loop():
    class Breaks:
        runs = 0

        def run(self, correction, /):
            Breaks.runs += 1
            return np.full_like(correction, np.inf if Breaks.runs == 2 else 0.5)

    trials = list(learn(Breaks(), Heuristic(Q=AllPass()), np.ones((20, 2)), 5))
    assert [trial.diverged for trial in trials] == [False, True]


def test_a_plant_without_error_never_diverges_however_the_limit_is_set():
    reference = moves()
    law = Heuristic(Q=AllPass())
    for ratio in (3.0, np.inf):
        *_, last = learn(Scaled(reference, 1.0), law, reference, 2, divergence_ratio=ratio)
        assert not last.diverged


def test_zero_error_is_a_fixed_point():
    reference = moves()
    law = Heuristic(Q=AllPass(), delta=3)
    trials = list(learn(Scaled(reference, 1.0), law, reference, 3))
    assert all(not trial.correction.any() for trial in trials)


def test_the_settings_of_chapter_9_learn_the_identified_servo():
    reference = moves()
    law = Heuristic(Q=ZeroPhaseButterworth(10.0, SAMPLE_TIME), gamma=0.9, delta=3)
    trials = list(learn(Arx(reference), law, reference, 5))
    peak = [np.abs(trial.error).max() for trial in trials]
    # |1 - LTu| <= 0.67 below 10 Hz, until what 1 - Q leaves over is reached at k = 3
    assert all(after < 0.67 * before for before, after in pairwise(peak[:4]))
    assert peak[5] < 0.01 * peak[0]


def test_design_variables_may_come_as_any_kind_of_number():
    error = moves(60, 2) - 0.3
    plain = Heuristic(Q=ZeroPhaseButterworth(10.0, SAMPLE_TIME), gamma=0.9, delta=3)
    Q = ZeroPhaseButterworth(np.int64(10), SAMPLE_TIME)
    odd = Heuristic(Q=Q, gamma=np.float32(0.9), delta=3.0)
    lists = Heuristic(
        Q=ZeroPhaseButterworth([10, 10], SAMPLE_TIME), gamma=np.array([0.9, 0.9]), delta=[3, 3.0]
    )
    expected = plain(0 * error, error)
    for law in (odd, lists):
        np.testing.assert_allclose(law(0 * error, error), expected, rtol=1e-6)


def test_the_loop_reads_the_output_from_whatever_the_plant_returns():
    class Recorder:
        def run(self, correction, /):
            return {"y": correction + 1.0}

    plant = Recorder()
    trials = list(
        learn(plant, Heuristic(Q=AllPass()), np.ones((20, 1)), 0, output_of=lambda log: log["y"])
    )
    assert trials[0].result["y"].shape == (20, 1)
    assert not trials[0].error.any()


def test_trials_cannot_be_changed_afterwards():
    (trial,) = learn(Scaled(moves(), 1.0), Heuristic(Q=AllPass()), moves(), 0)
    with pytest.raises(ValueError, match="read-only"):
        trial.error[0] = 1.0


def test_misfitting_arguments_are_refused_before_the_first_run():
    class Untouchable:
        def run(self, correction, /):
            raise AssertionError("ran")

    def start(law=None, reference=None, iterations=1, **options):
        law = law or Heuristic(Q=AllPass())
        reference = np.zeros((50, 6)) if reference is None else reference
        return learn(Untouchable(), law, reference, iterations, **options)

    with pytest.raises(ValueError, match="delta must stay within the record of 50"):
        start(Heuristic(Q=AllPass(), delta=50))
    with pytest.raises(ValueError, match="gamma must be one value or one for each of 6"):
        start(Heuristic(Q=AllPass(), gamma=(0.9, 0.8)))
    with pytest.raises(ValueError, match="reference must be finite, got nan at sample 3"):
        start(reference=np.where(np.arange(50)[:, None] == 3, np.nan, 0.0))
    with pytest.raises(ValueError, match="reference must have shape"):
        start(reference=np.zeros(50))
    with pytest.raises(ValueError, match="iterations must be >= 0"):
        start(iterations=-1)
    with pytest.raises(ValueError, match="first_correction must have the shape"):
        start(first_correction=np.zeros((50, 5)))


def test_an_output_of_another_shape_is_refused():
    class Short:
        def run(self, correction, /):
            return correction[:-1]

    with pytest.raises(ValueError, match="the output must have the shape"):
        next(learn(Short(), Heuristic(Q=AllPass()), np.zeros((50, 6)), 1))


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


def test_a_state_between_runs_does_not_change_in_place():
    state = ByHand(law=LAW, reference=np.zeros((50, 2)))
    with pytest.raises(FrozenInstanceError):
        setattr(state, "outputs", (np.zeros((50, 2)),))  # noqa: B010
