"""Learning data of several experiments give one model of the response to corrections."""

import numpy as np
import pytest

from armside.ilc.identification.first_order import (
    LearningRecord,
    fit_first_order,
    identify,
    learning_data,
)
from armside.ilc.models.system import System

STEP = 0.004
THESIS = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1.0, -0.4884]), STEP)


def experiment(seed, n_samples=300, motion_end=250, dtype=np.float64):
    """An experiment on the model of the thesis, with an arbitrary repeating error."""
    u, e_0 = np.random.default_rng(seed).standard_normal((2, n_samples, 6))
    u = System([0.2] * 5, [1], STEP).simulate(u)
    arrays = (u, e_0, e_0 - THESIS.simulate(u))
    return LearningRecord(*(array.astype(dtype) for array in arrays), motion_end)


def test_learning_data_are_sums_of_corrections_and_of_the_changes_of_the_output():
    ones = np.ones((4, 2))
    records = [LearningRecord(ones, 5 * ones, ones, 4), LearningRecord(2 * ones, 7 * ones, ones, 3)]
    u, y = learning_data(records)
    np.testing.assert_array_equal(u, 3 * ones[:3])
    np.testing.assert_array_equal(y, 10 * ones[:3])


def test_records_of_different_lengths_end_with_the_first_motion():
    u, y = learning_data([experiment(0), experiment(1, n_samples=400, motion_end=210)], [3, 5])
    assert u.shape == y.shape == (210, 2)


def test_the_model_behind_the_data_is_identified():
    found = identify([experiment(seed) for seed in range(3)], STEP, motors=(3, 5))
    assert found.delay == 5
    assert found.pole == pytest.approx(0.4884, abs=1e-4)
    assert found.fit > 0.9999


def test_single_precision_is_summed_as_stored():
    records = [experiment(seed, dtype=np.float32) for seed in range(3)]
    u, y = learning_data(records, [3, 5])
    assert u.dtype == y.dtype == np.float64
    expected = sum((r.first_error - r.last_error)[:250, [3, 5]] for r in records)
    np.testing.assert_array_equal(y, expected.astype(np.float64))
    assert identify(records, STEP, [3, 5]).pole == fit_first_order(u, y, STEP).pole


def test_data_without_records_or_motion_are_refused():
    with pytest.raises(ValueError, match="at least one record"):
        learning_data([])
    with pytest.raises(ValueError, match="motion_end must be >= 1 sample, got 0"):
        learning_data([experiment(0, motion_end=0)])
