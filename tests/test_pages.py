"""Pages of the docs name tests, modules and commands that exist, and what they say of tables holds.

docs/thesis.md has every item of the thesis; findings, peers, identification and ilc lead to tests.
"""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from tests import evidence

from armside.scripts import cli
from armside.scripts.shell.parser import make_app

ROOT = Path(__file__).parent.parent
TESTS, DOCS = ROOT / "tests", ROOT / "docs"
TICK = re.compile(r"\[✓\]\(\.\./tests/([\w/]+\.py) \"(\w+)\"\)")
NAMED = re.compile(r"`([\w/]+\.py)::(\w+)`")


def text(page: str) -> str:
    return (DOCS / page).read_text(encoding="utf-8")


COUNTS = {"K": 18, "E": 10, "L": 7, "S": 6, "X": 10, "F": 9}
"""Items of part I, chapters 5, 7, 8 and 9, and of the future work."""
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in text("thesis.md").splitlines()
    if re.match(r"\| [KELSXF]\d\d \|", line)
]


def test_every_item_has_one_row():
    expected = [f"{letter}{i:02}" for letter, n in COUNTS.items() for i in range(1, n + 1)]
    assert [row[0] for row in ROWS] == expected


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_a_row_leads_to_what_exists(row):
    _, what, modules, test, command, _ = row
    assert what
    found = re.findall(r"`([^`]+)`", modules)
    assert found
    for module in found:
        assert (ROOT / module).is_file(), module
    if test != "**open**":
        file, _, name = test.strip("`").partition("::")
        assert f"def {name}(" in (ROOT / "tests" / file).read_text(encoding="utf-8"), test
    if command:
        words = shlex.split(command.strip("`"))
        if words[0] == "make":
            assert evidence.is_made(command.strip("`"))
        else:
            assert words[0] == "armside"
            make_app(cli.COMMANDS, cli.load, words[1]).parse_args(words[1:])


def test_the_sentence_of_x08_has_the_numbers_of_its_table():
    """Fractions of the error of k = 0 that are left, over all seeds of the claim chapter9."""
    (said,) = (row[-1] for row in ROWS if row[0] == "X08")
    table = text("claims/chapter9.md")
    rows = {
        match[1]: np.array(
            [float(value) for value in re.findall(r"\| (-?\d[\d.]*) (?=\|)", match[2])]
        )
        for match in re.finditer(r"^\| (b[167]) \|(.*)$", table, re.MULTILINE)
    }
    p1 = rows["b1"]
    p2, p3 = p1 + rows["b6"], p1 + rows["b6"] + rows["b7"]
    before, after = map(float, re.findall(r"\((\d+) → (\d+) µm\)", said)[0])
    assert after / before == pytest.approx(p2[0], abs=0.005)
    assert "p1 better; p2 better" in said
    assert max(p1.max(), p2.max()) < 0.7
    assert "p3 mostly not" in said
    assert p3.min() > 1.0


def test_each_test_of_the_findings_exists():
    sources = (file.read_text(encoding="utf-8") for file in TESTS.rglob("test_*.py"))
    known = {name for source in sources for name in re.findall(r"def (test_\w+)\(", source)}
    named = set(re.findall(r"`(test_\w+)`", text("findings.md")))
    assert len(named) > 50
    assert named <= known


def test_a_finding_without_a_test_says_why():
    rows = re.findall(r"^\| (.+) \| none \| (.*) \|$", text("findings.md"), re.M)
    assert rows
    assert all(len(reason) > 3 for _, reason in rows)


def pairs(page: str, pattern: re.Pattern[str]) -> list[tuple[str, str]]:
    return pattern.findall(text(page))


@pytest.mark.parametrize(
    ("page", "pattern", "least"),
    [("peers.md", TICK, 30), ("identification.md", NAMED, 10), ("ilc.md", NAMED, 18)],
)
def test_each_test_that_a_page_leads_to_exists(page, pattern, least):
    found = pairs(page, pattern)
    assert len(found) >= least
    for file, name in found:
        assert f"def {name}(" in (TESTS / file).read_text(encoding="utf-8"), (file, name)


def test_every_tick_is_a_link():
    ticks = text("peers.md").count("✓")
    assert ticks == len(pairs("peers.md", TICK))


def test_every_interval_that_is_tested_here_is_on_the_page():
    source = (TESTS / "test_intervals.py").read_text(encoding="utf-8")
    listed = re.search(r"^INTERVALS = \((.*?)^\)", source, re.MULTILINE | re.DOTALL)
    assert listed
    named = {
        name for file, name in pairs("identification.md", NAMED) if file == "test_intervals.py"
    }
    tested = set(re.findall(r"\w+", listed[1]))
    assert tested - {"nees_of_the_filter", "nees_of_the_smoother"} == named - {"nees"}
