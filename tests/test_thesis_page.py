"""docs/thesis.md names every item, and only modules, tests and commands that exist."""

import re
import shlex
from pathlib import Path

import pytest

from armside.scripts import cli
from armside.scripts.shell.parser import make_app

ROOT = Path(__file__).parent.parent
COUNTS = {"K": 18, "E": 10, "L": 7, "S": 6, "X": 10, "F": 9}
"""Items of part I, chapters 5, 7, 8 and 9, and of the future work."""
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in (ROOT / "docs" / "thesis.md").read_text(encoding="utf-8").splitlines()
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
        assert words[0] == "armside"
        make_app(cli.COMMANDS, cli.load, words[1]).parse_args(words[1:])
