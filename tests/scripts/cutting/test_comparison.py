"""Work that a comparison of measurements asks for."""

import pytest

from armside.scripts.cutting.comparison import CompareCfg, refuse_absurd_comparison
from armside.scripts.shell import effort
from armside.scripts.shell.errors import InputError


def test_the_runs_of_a_comparison_are_of_each_way_case_and_iteration(monkeypatch):
    """Four ways (motor, estimate, tracker, oracle) x 5 x (3 + 1); a twin is a fifth."""
    monkeypatch.setattr(effort, "LONGEST", 0.0)
    with pytest.raises(InputError, match=r"^80 runs at 20 mm/s and more"):
        refuse_absurd_comparison(CompareCfg(iterations=3, speeds=(40.0, 20.0)), 5)
