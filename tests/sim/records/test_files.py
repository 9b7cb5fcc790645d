"""Sizes that are refused, with the bound."""

import re

import pytest

from armside.sim.records.files import LARGEST_DATA, InputError, check_n_values


def test_numbers_that_do_not_fit_are_refused_in_megabytes(tmp_path):
    n = LARGEST_DATA // 8
    check_n_values(tmp_path / "a.npz", n)
    said = f"a.npz unpacks to {16 * n / 1e6:.4g} MB; at most {LARGEST_DATA / 1e6:.4g} MB are read"
    with pytest.raises(InputError, match=re.escape(said)):
        check_n_values(tmp_path / "a.npz", 2 * n)
    with pytest.raises(InputError, match="unpacks"):
        check_n_values(tmp_path / "a.npz", n + 1)
