"""Compiled functions are compiled for one kind of array, so a fresh checkout waits once."""

import numpy as np

from armside.arrays import read_only
from armside.ilc.estimation import kalman
from armside.ilc.estimation.process import Process


def test_arrays_that_may_be_written_to_and_others_share_one_smoother():
    matrix = np.eye(2)
    process = Process(A=0.9 * matrix, Q=matrix, C=matrix, R=matrix)
    found = [
        kalman.Smoother(process, start, seen).filtered_covariance
        for start in (matrix, read_only(matrix), np.asfortranarray(matrix))
        for seen in (np.ones(3, dtype=bool), np.ones((3, 2), dtype=bool))
    ]
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])
    assert len(kalman._covariances.signatures) == 1


def test_what_is_read_only_shares_its_memory_and_leaves_the_array_as_it_was():
    array = np.zeros((2, 3))
    view = read_only(array)
    assert np.shares_memory(view, array)
    assert not view.flags.writeable
    assert array.flags.writeable
    assert read_only(array.T).flags.c_contiguous
