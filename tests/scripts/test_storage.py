"""Storages of `armside tune` that cannot be had."""

QUICK = "--pose p1 --speed 60 --payload 40 --episodes 1 --iterations 1"


def test_a_mode_that_sqlite_would_not_see_is_refused_and_nothing_is_made(bad_input):
    said = "?mode= is part of an SQLite URI: sqlite:///file:a.db?mode=ro&uri=true"
    bad_input(f"tune {QUICK} --storage sqlite:///a.db?mode=ro", said)
