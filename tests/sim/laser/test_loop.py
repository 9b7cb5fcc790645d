"""Where a loop of learning ends."""

from dataclasses import replace
from itertools import islice

from armside import assets
from armside.sim.laser import Cut, learn

CUT = Cut(robot=str(assets.LARGE_ROBOT_XML.with_name("two_link.toml")))


def test_a_loop_that_is_gone_on_from_ends_after_as_many_updates_as_are_asked_for():
    """Also beyond 256, from where on equal numbers are not one object."""
    (first,) = learn(CUT, iterations=0, seed=0)
    later = replace(first.state, loop=replace(first.state.loop, k=300))
    iterations = islice(learn(CUT, iterations=2, start=later, seed=0), 5)
    assert [iteration.k for iteration in iterations] == [0, 301, 302]


def test_a_cut_is_learned_by_five_updates_where_no_number_is_given():
    assert [iteration.k for iteration in learn(CUT, seed=0)] == [0, 1, 2, 3, 4, 5]
