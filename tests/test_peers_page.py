"""A tick or a test on the pages of peers, identification and ilc leads to a test that exists."""

import re
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
DOCS = TESTS.parent / "docs"
TICK = re.compile(r"\[✓\]\(\.\./tests/([\w/]+\.py) \"(\w+)\"\)")
NAMED = re.compile(r"`([\w/]+\.py)::(\w+)`")


def pairs(page: str, pattern: re.Pattern[str]) -> list[tuple[str, str]]:
    return pattern.findall((DOCS / page).read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("page", "pattern", "least"),
    [("peers.md", TICK, 30), ("identification.md", NAMED, 10), ("ilc.md", NAMED, 20)],
)
def test_each_test_that_a_page_leads_to_exists(page, pattern, least):
    found = pairs(page, pattern)
    assert len(found) >= least
    for file, name in found:
        assert f"def {name}(" in (TESTS / file).read_text(encoding="utf-8"), (file, name)


def test_every_tick_is_a_link():
    text = (DOCS / "peers.md").read_text(encoding="utf-8")
    assert text.count("✓") == len(TICK.findall(text))


def test_every_interval_that_is_tested_here_is_on_the_page():
    source = (TESTS / "test_intervals.py").read_text(encoding="utf-8")
    listed = re.search(r"^INTERVALS = \((.*?)^\)", source, re.MULTILINE | re.DOTALL)
    assert listed
    named = {
        name for file, name in pairs("identification.md", NAMED) if file == "test_intervals.py"
    }
    tested = set(re.findall(r"\w+", listed[1]))
    assert tested - {"nees_of_the_filter", "nees_of_the_smoother"} == named - {"nees"}
