"""Cuts that tell the most about an individual."""

from types import SimpleNamespace

import numpy as np
import pytest

from armside.sim.twin import commission


def test_cuts_are_taken_by_what_they_add_to_the_logarithm_of_the_determinant(monkeypatch):
    """Of two parameters known to 1 and 0.5 before: their weights begin as 1 and 4.

    The second raises 4 to 20, the others 1 to 4; that of the curve of the second waits until the
    other curve was cut, and then raises 4 to 7.
    """
    adds = {"first": (3.0, 0.0), "second": (0.0, 16.0)}
    names = [("first", "x"), ("second", "y"), ("first", "y")]
    cuts = [SimpleNamespace(name=name, curve=curve) for name, curve in names]
    known = SimpleNamespace(standard_deviation=np.array([1.0, 0.5]))
    monkeypatch.setattr(commission, "parameters_of", lambda design: known)
    monkeypatch.setattr(commission, "_information", lambda _, cut: np.diag(adds[cut.name]))
    taken = commission.chosen(None, 3, cuts)
    assert [choice.number for choice in taken] == [1, 0, 2]
    assert [choice.gain for choice in taken] == pytest.approx(np.log([5.0, 4.0, 7.0 / 4.0]))
