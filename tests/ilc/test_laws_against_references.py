"""Laws, designs and fits against independent formulas, and the defaults that users rely on."""

import numpy as np
import pytest

from armside.ilc.analysis.robustness import PARAMETERS, monte_carlo
from armside.ilc.divergence import DIVERGENCE_RATIO, has_diverged
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.identification.first_order_lag import fit_first_order
from armside.ilc.laws import Heuristic
from armside.ilc.laws.first_order import FirstOrderLaw
from armside.ilc.laws.model_based import RegularisedInverse
from armside.ilc.laws.wrappers import Guarded
from armside.ilc.measures.norms import circle_ripple
from armside.ilc.models.system import System
from armside.ilc.models.two_mass import TwoMassLoop

N, STEP = 64, 0.004
MIX = np.array([[1.0, 0.3], [-0.2, 0.8]])


class Gain:
    """Two outputs of two inputs: a constant mix behind one lag and a delay of three samples."""

    def __init__(self, mix=MIX, scale=1.0):
        self.mix = scale * np.asarray(mix)

    def response(self, omega):
        z = np.exp(1j * np.asarray(omega))
        return (z**-3 * 0.4 / (1 - 0.6 / z))[:, None, None] * self.mix


def inverse(**options):
    given = {"G": Gain(), "sample_time": STEP, "cutoff": 25.0, "output_weight": (1.0, 0.5)}
    return RegularisedInverse(**given | {"input_size": (2.0, 0.1)} | options)


def test_a_correction_stays_within_the_limit_of_each_input():
    law = inverse(limit=0.01)
    e = 100.0 * np.random.default_rng(1).standard_normal((N, 2))
    u = law(np.zeros((N, 2)), e)
    assert np.abs(u).max(axis=0) == pytest.approx([0.02, 0.001])
    free = inverse(limit=np.inf)(np.zeros((N, 2)), e)
    assert u == pytest.approx(np.clip(free, [-0.02, -0.001], [0.02, 0.001]))


class Step(FirstOrderLaw):
    """u + 0.5 e."""

    def __call__(self, correction, error, /):
        return correction + 0.5 * error


def guarded(sizes, **options):
    """Corrections after errors of these sizes, each a constant record, and the last memory."""
    law = Guarded(law=Step(), weight=(1.0, 0.0), **options)
    u, memory, found = np.zeros((4, 2)), None, []
    for size in sizes:
        u, memory = law.step(u, np.full((4, 2), float(size)), memory)
        found.append(u[0, 0])
    return found, memory


@pytest.mark.parametrize(("growth", "back"), [(1.199, False), (1.201, True)])
def test_an_error_a_fifth_above_the_best_is_growth(growth, back):
    _, memory = guarded([1.0, growth])
    assert memory.setbacks == int(back)
    assert memory.size == 1.0


def test_columns_of_no_weight_do_not_count_for_a_guard():
    law = Guarded(law=Step(), weight=(2.0, 0.0))
    assert law.size(np.array([[3.0, 100.0], [4.0, 100.0]])) == pytest.approx(2 * np.sqrt(12.5))


@pytest.mark.parametrize(("ratio", "diverged"), [(2.99, False), (3.01, True)])
def test_learning_has_diverged_above_three_times_its_first_error(ratio, diverged):
    assert DIVERGENCE_RATIO == 3.0
    first = np.array([1.0, 2.0, 3.0])
    size = first * np.array([0.1, ratio, 0.1])  # one motor is enough
    assert has_diverged(size, first) is diverged
    assert has_diverged(np.array([1.0, np.nan, 1.0]), first)


# Identification and robustness


@pytest.mark.parametrize("pole", [0.3, 0.8, 0.95, 0.975])
def test_output_error_finds_a_first_order_response_exactly(pole):
    rng = np.random.default_rng(4)
    true = System(np.array([0.0, 0.0, 0.0, 1.02 * (1 - pole)]), np.array([1.0, -pole]), STEP)
    u = np.cumsum(rng.standard_normal((400, 2)), axis=0)
    found = fit_first_order(u, true.simulate(u), STEP)
    assert (found.delay, found.static_gain) == (3, pytest.approx(1.02, rel=1e-3))
    assert found.pole == pytest.approx(pole, abs=1e-4)
    assert found.total_delay == pytest.approx(3 + pole / (1 - pole), rel=1e-2)
    assert found.fit > 0.999


def test_the_fit_is_relative_to_the_deviation_from_the_mean():
    """An output that is noise about a large mean is not explained by a model of the mean."""
    rng = np.random.default_rng(5)
    u = np.ones((300, 1))
    y = 10.0 + rng.standard_normal((300, 1))
    assert fit_first_order(u, y, STEP, delays=[0]).fit < 0.3


def test_uncertain_parameters_spread_by_what_is_asked():
    """Each factor is exp of a uniform number within +- log(1 + spread)."""
    law = Heuristic(Q=ZeroPhaseButterworth(6.0, 0.01), gamma=0.9, delta=5)
    found = monte_carlo(TwoMassLoop(), law, 0.3, 150, np.random.default_rng(7))
    assert PARAMETERS == ("k", "d", "Ja", "Jm", "fm", "kt")
    assert found.factors.shape == (150, 6)
    log = np.log(found.factors)
    width = np.log(1.3)
    assert np.abs(log).max() <= width
    assert np.abs(log).max() > 0.97 * width
    n = log.size
    assert log.std() == pytest.approx(width / np.sqrt(3), rel=5 / np.sqrt(2 * n))
    assert 0.0 <= found.fraction_converging <= 1.0


def test_the_reference_filter_stays_as_designed_when_the_joint_differs():
    from armside.ilc.analysis.robustness import _scaled

    loop = TwoMassLoop()
    other = _scaled(loop, {"k": 2.0, "fm": 0.5})
    assert (other.joint.k, other.joint.fm) == (10.0, pytest.approx(0.5 * 0.0713))
    assert other.F_r.b == pytest.approx(loop.F_r.b)


# Systems and measures


@pytest.mark.parametrize("n", [196, 197])
def test_ripple_over_all_frequencies_is_the_standard_deviation_of_the_radius(n):
    """Parseval, for even and odd numbers of samples."""
    radii = 5e-3 + 1e-4 * np.random.default_rng(8).standard_normal(n)
    assert circle_ripple(radii, 0.785, 0.0, np.inf) == pytest.approx(radii.std(), rel=1e-9)
    t = np.arange(n) / n
    wave = 5e-3 + 1e-4 * np.sin(2 * np.pi * 8 * t)
    assert circle_ripple(wave, 0.785, 5.0, 14.0) == pytest.approx(1e-4 / np.sqrt(2))
    assert circle_ripple(wave, 0.785, 14.0, 100.0) == pytest.approx(0.0, abs=1e-12)
