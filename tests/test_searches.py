"""A search that was made is found again for the same record alone."""

from dataclasses import dataclass

import numpy as np
import pytest
from tests.searches import once


@dataclass(frozen=True)
class Record:
    signal: np.ndarray
    gain: float = 1.0


@pytest.mark.parametrize(
    ("other", "searches"),
    [
        (Record(np.arange(3.0)), 1),
        (Record(np.arange(3.0), 1.0 + 1e-15), 2),
        (Record(np.arange(3.0) + 1e-12), 2),
        (Record(np.arange(3)), 2),
    ],
)
def test_a_search_is_made_once_for_the_same_bits(tmp_path, other, searches):
    def made_once(name, make):
        if not (tmp_path / name).exists():
            make(tmp_path / name)
        return tmp_path / name

    made = []
    search = once(lambda one: made.append(one) or one.signal.sum(), made_once)
    assert search(Record(np.arange(3.0))) == search(Record(np.arange(3.0)))
    assert search(other) == other.signal.sum()
    assert len(made) == searches
