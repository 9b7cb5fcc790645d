"""A check that needs a program is skipped by name where it is missing, but never in CI."""

import pytest

MISSING = "no-such-program-of-armside"


def test_the_first_program_that_exists_is_given(require_program):
    assert require_program(MISSING, "sh").endswith("/sh")


def test_a_missing_program_skips_and_is_named(require_program, monkeypatch):
    monkeypatch.delenv("ARMSIDE_CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match=MISSING):
        require_program(MISSING)


def test_a_missing_program_fails_in_ci(require_program, monkeypatch):
    monkeypatch.setenv("ARMSIDE_CI", "1")
    with pytest.raises(pytest.fail.Exception, match=f"{MISSING}.*must install"):
        require_program(MISSING)
