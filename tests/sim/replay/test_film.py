"""Times of the pictures of a film."""

from types import SimpleNamespace

import numpy as np

from armside.sim.replay.film import RATE, _times


def test_a_film_has_twelve_and_a_half_pictures_in_each_second_of_a_run():
    run = SimpleNamespace(recording=SimpleNamespace(time=np.arange(0.0, 2.001, 0.01)))
    assert RATE == 12.5
    np.testing.assert_allclose(_times(run), 0.08 * np.arange(25), atol=1e-12)  # below 2 s
