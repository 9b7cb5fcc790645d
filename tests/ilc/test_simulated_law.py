"""Learning on a simulated plant between runs, where friction makes a linear T_u wrong."""

from dataclasses import dataclass

import numpy as np
import pytest

from armside.ilc import AllPass, Heuristic, learn
from armside.ilc.laws.wrappers import Simulated

from .signals import bump

REFERENCE = bump()
PLAIN = Heuristic(Q=AllPass(), gamma=1.0)


@dataclass(frozen=True)
class Stiction:
    """Output that follows r + u only once it is further away than the friction holds."""

    width: float
    gain: float = 1.0

    def run(self, correction, /):
        output, held = np.zeros_like(correction), 0.0
        for i, asked in enumerate(self.gain * (REFERENCE + correction)[:, 0]):
            held = np.clip(held, asked - self.width, asked + self.width)
            output[i] = held
        return output


def simulated(plant, **options):
    law = {"law": PLAIN, "weight": (1.0,)} | options
    return Simulated(simulation=lambda u: REFERENCE - plant.run(u), **law)


def largest(plant, law, iterations):
    trials = learn(plant, law, REFERENCE, iterations, divergence_ratio=np.inf)
    return np.array([np.abs(trial.error).max() for trial in trials])


def test_a_right_simulation_learns_from_one_run_more_than_plain_learning_from_five():
    plant = Stiction(0.3)
    plain = largest(plant, PLAIN, 5)
    between_runs = largest(plant, simulated(plant, passes=20), 1)
    assert between_runs[1] < 0.5 * plain[-1]


def test_a_wrong_simulation_still_ends_below_plain_learning():
    real, nominal = Stiction(0.3, gain=0.95), Stiction(0.27)
    by_model, plain = (largest(real, law, 5) for law in (simulated(nominal), PLAIN))
    assert by_model[0] == plain[0]
    assert by_model[-1] < 0.5 * plain[-1]


def test_no_pass_is_kept_that_makes_the_residual_larger():
    growing = Heuristic(Q=AllPass(), gamma=5.0)
    law = simulated(Stiction(0.0), law=growing)
    error = REFERENCE - Stiction(0.0).run(np.zeros_like(REFERENCE)) + 0.1
    correction = law(np.zeros_like(REFERENCE), error)
    np.testing.assert_array_equal(correction, 0.0)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: simulated(Stiction(0.3), passes=0), "passes must be >= 1, got 0"),
        (lambda: simulated(Stiction(0.3), weight=(1.0, 1.0)).check(90, 1), "weight must have 1 "),
    ],
)
def test_a_law_that_cannot_be_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()
