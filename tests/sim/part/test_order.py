"""Order of cuts beside all orders there are."""

from itertools import pairwise, permutations

import numpy as np
import pytest

from armside.sim.part.order import _exchange, _length, _shift, order


def way(indices, entry, leave, start):
    ends = np.vstack([start, leave[list(indices[:-1])]])
    return float(np.linalg.norm(entry[list(indices)] - ends, axis=1).sum())


@pytest.mark.parametrize("move", [_exchange, _shift])
def test_no_exchange_makes_the_way_longer(move):
    """Ways there and back differ, as cuts begin and end at different places."""
    rng = np.random.default_rng(0)
    for n in (2, 3, 5, 8):
        for _ in range(50):
            D, tour = rng.uniform(0.1, 1.0, (n + 1, n)), rng.permutation(n)
            after = move(tour, D)
            assert sorted(after) == list(range(n))
            assert _length(after, D) <= _length(tour, D) + 1e-12


def test_five_cuts_are_mostly_in_the_shortest_order_there_is():
    """Exchanges find it in nine of ten drawings; the nearest neighbour alone in six."""
    rng, ratios = np.random.default_rng(1), []
    for _ in range(60):
        entry, leave, start = (rng.uniform(0, 1, shape) for shape in ((5, 2), (5, 2), 2))
        found = order(entry, leave, [0] * 5, start)
        best = min(way(each, entry, leave, start) for each in permutations(range(5)))
        ratios.append(way(found, entry, leave, start) / best)
    assert np.mean(np.array(ratios) < 1.0 + 1e-9) > 0.8
    assert np.max(ratios) < 1.5


def test_what_is_inside_is_cut_before_what_is_around_it():
    rng = np.random.default_rng(1)
    places = rng.uniform(0.0, 1.0, (30, 2))
    depth = rng.integers(0, 4, 30).tolist()
    found = order(places, places, depth, np.zeros(2))
    assert sorted(found) == list(range(30))
    assert all(depth[a] >= depth[b] for a, b in pairwise(found))
