"""Q and q^delta along finished records."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal as reference_implementation

from armside.ilc.filters import AllPass, Edge, End, ZeroPhaseButterworth, butterworth, shift

SAMPLE_TIME = 0.004


@settings(max_examples=40, deadline=None)
@given(
    cutoff=st.floats(0.5, 120.0),
    order=st.integers(1, 4),
    n_samples=st.integers(14, 300),
    seed=st.integers(0, 100),
)
def test_odd_edges_are_matlabs_filtfilt(cutoff, order, n_samples, seed):
    record = np.random.default_rng(seed).standard_normal((n_samples, 2))
    b, a = reference_implementation.butter(order, cutoff * 2 * SAMPLE_TIME)
    expected = reference_implementation.filtfilt(b, a, record, axis=0, padlen=3 * order)
    filtered = ZeroPhaseButterworth(cutoff, SAMPLE_TIME, order)(record)
    # scipy's polynomial form loses digits at order 4, ours (sections) does not.
    np.testing.assert_allclose(filtered, expected, atol=1e-6 if order > 2 else 1e-10)


def test_rest_edges_filter_a_record_that_is_zero_outside():
    record = np.random.default_rng(0).standard_normal((50, 2))
    Q = ZeroPhaseButterworth(20.0, SAMPLE_TIME, edge=Edge.REST)
    longer = np.concatenate((np.zeros((400, 2)), record, np.zeros((400, 2))))
    b, a = reference_implementation.butter(2, 20.0 * 2 * SAMPLE_TIME)
    once = reference_implementation.lfilter(b, a, longer, axis=0)
    twice = reference_implementation.lfilter(b, a, once[::-1], axis=0)[::-1]
    np.testing.assert_allclose(Q(record), twice[400:450], atol=1e-12)
    # what a record of zeros before and after it leaves is the same
    np.testing.assert_allclose(Q(record), Q(longer)[400:450], atol=1e-12)


def test_rest_edges_do_not_prefer_a_direction_of_time():
    record = np.random.default_rng(1).standard_normal((60, 1))
    Q = ZeroPhaseButterworth(3.0, SAMPLE_TIME, order=3, edge=Edge.REST)
    np.testing.assert_allclose(Q(record[::-1])[::-1], Q(record), atol=1e-12)


def test_a_cutoff_that_rings_for_hours_is_refused():
    with pytest.raises(ValueError, match=r"rings for .* samples with Edge.REST"):
        ZeroPhaseButterworth(1e-5, SAMPLE_TIME, edge=Edge.REST)(np.ones((50, 1)))


def test_coefficients_are_the_reference_values_m5():
    (b, a), *others = butterworth(17.0, 0.01, 2)
    assert not others
    np.testing.assert_allclose(b, [0.159987886, 0.319975772, 0.159987886], atol=1e-8)
    np.testing.assert_allclose(a, [1, -0.594888940, 0.234840484], atol=1e-8)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_gain_is_one_half_at_the_cutoff_and_one_at_rest(order):
    Q = ZeroPhaseButterworth(10.0, SAMPLE_TIME, order)
    gains = Q.response([0.0, 2 * np.pi * 10.0 * SAMPLE_TIME])
    np.testing.assert_allclose(gains, [1.0, 0.5], atol=1e-12)


def test_a_cutoff_for_each_column_filters_each_column_alone():
    record = np.random.default_rng(1).standard_normal((100, 3))
    together = ZeroPhaseButterworth((5.0, 20.0, 5.0), SAMPLE_TIME)(record)
    for column, cutoff in enumerate((5.0, 20.0, 5.0)):
        alone = ZeroPhaseButterworth(cutoff, SAMPLE_TIME)(record[:, [column]])
        np.testing.assert_allclose(together[:, [column]], alone, atol=1e-14)


def test_a_constant_passes_odd_edges_unchanged():
    filtered = ZeroPhaseButterworth(1.0, SAMPLE_TIME)(np.full((100, 1), 3.0))
    np.testing.assert_allclose(filtered, 3.0, rtol=1e-12)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 125.0, 200.0, np.nan, np.inf, (10.0, 125.0)])
def test_a_cutoff_outside_zero_to_nyquist_is_refused(cutoff):
    with pytest.raises(ValueError, match=r"cutoff .* Nyquist frequency 125 Hz"):
        ZeroPhaseButterworth(cutoff, SAMPLE_TIME)


def test_filters_and_shifts_that_do_not_fit_the_record_are_refused():
    with pytest.raises(ValueError, match="one for each of 6, got 2"):
        ZeroPhaseButterworth((1.0, 2.0), SAMPLE_TIME)(np.zeros((100, 6)))
    with pytest.raises(ValueError, match="longer than the pad of 6"):
        ZeroPhaseButterworth(1.0, SAMPLE_TIME)(np.zeros((6, 1)))
    with pytest.raises(ValueError, match="order must be"):
        ZeroPhaseButterworth(1.0, SAMPLE_TIME, order=5)
    with pytest.raises(ValueError, match="sample_time"):
        ZeroPhaseButterworth(1.0, float("nan"))


def test_the_shift_looks_ahead_for_positive_delta_and_holds_or_clears_the_end():
    record = np.array([[1.0], [2.0], [3.0], [4.0]])
    assert shift(record, 1)[:, 0].tolist() == [2, 3, 4, 4]
    assert shift(record, 1, End.ZERO)[:, 0].tolist() == [2, 3, 4, 0]
    assert shift(record, -2)[:, 0].tolist() == [1, 1, 1, 2]
    assert shift(record, -2, End.ZERO)[:, 0].tolist() == [0, 0, 1, 2]
    assert shift(record, 0)[:, 0].tolist() == [1, 2, 3, 4]


def test_each_column_has_its_own_shift():
    record = np.arange(8.0).reshape(4, 2)
    np.testing.assert_array_equal(
        shift(record, (0, 2)), np.column_stack((record[:, 0], shift(record[:, [1]], 2)))
    )


@pytest.mark.parametrize("delta", [4, -4, 99, (0, 4)])
def test_a_shift_beyond_the_record_is_refused(delta):
    with pytest.raises(ValueError, match="within the record of 4 samples"):
        shift(np.zeros((4, 2)), delta)


def test_q_equal_to_one_returns_a_copy():
    record = np.ones((3, 1))
    filtered = AllPass()(record)
    assert filtered is not record
    np.testing.assert_array_equal(filtered, record)
    np.testing.assert_array_equal(AllPass().response([0.0, 1.0]), [1.0, 1.0])


def test_importing_the_laws_spares_the_slow_imports():
    slow = ("scipy.signal", "control", "matplotlib", "numba", "sympy")
    code = f"import sys, ilc; print([m for m in {slow} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
