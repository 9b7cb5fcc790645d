"""Results that figures share are kept. Seconds are measured by `make bench NAME=ilc`."""

from armside.ilc import two_mass_study


def test_500_iterations_are_run_once_for_all_figures():
    assert two_mass_study.learned(17.0) is two_mass_study.learned(17.0)
