"""An encoder counts motor turns; its steps on the arm side are n times finer."""

import numpy as np
import pytest

from armside.sim.instruments.encoder import quantise, resolution


def test_one_count_of_the_thesis_is_a_milliradian_and_a_half_of_the_motor():
    # Thesis 5.3.1: 2 pi / (2^12 - 1) on the motor side, here 118 times finer on the arm side.
    assert resolution(2**12 - 1, 118.0) * 118.0 == pytest.approx(0.0015, abs=5e-5)


def test_the_error_is_at_most_half_a_count_and_uniform():
    ratio = np.array([220.0, -145.0])
    angle = np.random.default_rng(1).uniform(-1, 1, (100_000, 2))
    q = resolution(16384, ratio)
    error = quantise(angle, 16384, ratio) - angle
    assert np.all(np.abs(error) <= q / 2 * (1 + 1e-9))
    np.testing.assert_allclose(error.std(axis=0), q / np.sqrt(12), rtol=0.01)


def test_readings_are_whole_counts_and_read_again_as_themselves():
    angle = np.random.default_rng(2).uniform(-3, 3, (1000, 6))
    ratio = np.array([220, 242.73, 242.73, 145, 180, 100])
    once = quantise(angle, 16384, ratio)
    counts = once / resolution(16384, ratio)
    np.testing.assert_allclose(counts, np.rint(counts), rtol=0, atol=1e-8)
    np.testing.assert_array_equal(quantise(once, 16384, ratio), once)


def test_counts_and_ratios_must_make_sense():
    with pytest.raises(ValueError, match="counts per turn"):
        resolution(0, 100.0)
    with pytest.raises(ValueError, match="gear ratios"):
        resolution(4096, [100.0, 0.0])
