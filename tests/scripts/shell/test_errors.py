"""Packages that are not installed, and modules of ours that are not there."""

import pytest

from armside.scripts.shell.errors import InputError, needs


@pytest.mark.parametrize("name", ["aaa", "zzz.part", "armsides"])
def test_a_package_of_others_is_asked_for_by_its_extra(name):
    said = r"^armside tune needs It: pip install 'armside\[rl\]'"
    with pytest.raises(InputError, match=said), needs("rl", "armside tune", "It"):
        raise ModuleNotFoundError(name=name)


def test_a_module_of_ours_that_is_missing_is_our_fault():
    with pytest.raises(ModuleNotFoundError), needs("rl", "armside tune", "It"):
        raise ModuleNotFoundError(name="armside.sim.none")
