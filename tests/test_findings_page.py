"""The page of findings names tests that exist."""

import re
from pathlib import Path

TESTS = Path(__file__).parent
PAGE = TESTS.parent / "docs" / "findings.md"


def test_each_test_of_the_page_exists():
    sources = (file.read_text(encoding="utf-8") for file in TESTS.rglob("test_*.py"))
    known = {name for text in sources for name in re.findall(r"def (test_\w+)\(", text)}
    named = set(re.findall(r"`(test_\w+)`", PAGE.read_text(encoding="utf-8")))
    assert len(named) > 50
    assert named <= known


def test_a_finding_without_a_test_says_why():
    rows = re.findall(r"^\| (.+) \| none \| (.*) \|$", PAGE.read_text(encoding="utf-8"), re.M)
    assert rows
    assert all(len(reason) > 3 for _, reason in rows)
