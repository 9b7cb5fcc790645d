"""Work that a comparison of laws asks for."""

import pytest

from armside.scripts.shell.effort import DAY
from armside.scripts.shell.errors import InputError
from armside.scripts.workbench import plant_option
from armside.scripts.workbench.options import LearnCfg


def test_the_runs_of_a_comparison_are_of_each_law_noise_repeat_and_iteration(monkeypatch):
    """3 x 2 x 5 x (7 + 1)."""
    cfg = LearnCfg(laws=("p", "pd", "bfgs"), noise=(0.0, 1.0), repeats=5, iterations=7)
    monkeypatch.setattr(plant_option, "SECONDS_LINEAR", DAY)
    with pytest.raises(InputError, match=r"^240 runs of \d+ numbers"):
        plant_option.named_task(cfg, 0)
