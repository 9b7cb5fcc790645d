"""Commands and code of README and the docs work as written.

A block marked `python` is run; the blocks of one page share their names, as a reader's would.
In blocks marked `sh` or `console` each line that starts with `armside` is run, with or without
`$ ` before it. Commands that take minutes are only parsed.
"""

import re
import shlex
from pathlib import Path
from typing import NamedTuple

import pytest

from armside.scripts import cli
from armside.scripts.shell.parser import parse

ROOT = Path(__file__).parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
TAKES_MINUTES = {"bench", "calibrate", "compare", "reproduce", "verify"}
SHOWS = {"view": {"view"}, "replay": {"--web", "--png", "--video"}}
"""Commands that open a window, serve until they are stopped, or need a GL library: their own tests
run them."""
FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A fenced block of a page."""

    language: str
    text: str
    line: int


def blocks(page: str) -> list[Block]:
    return [
        Block(found[1], found[2], page.count("\n", 0, found.start()) + 1)
        for found in FENCE.finditer(page)
    ]


def commands(block: Block) -> list[str]:
    """The armside commands of a block, long lines joined, comments dropped."""
    if block.language not in {"sh", "console", "bash", "shell"}:
        return []
    lines = block.text.replace("\\\n", " ").splitlines()
    typed = [line.removeprefix("$ ").strip() for line in lines]
    return [line for line in typed if line.split()[:1] == ["armside"]]


def run_command(command: str) -> None:
    words = shlex.split(command, comments=True)[1:]
    if words and (words[0] in TAKES_MINUTES or only_shows(words)):
        parse(words, cli.COMMANDS, cli.load)
    else:
        assert cli.main(words) == 0, command


def only_shows(words: list[str]) -> bool:
    """True for a command without a result; a replay without a file to write opens a window."""
    opens_window = words[0] == "replay" and "--save" not in words
    return opens_window or bool(SHOWS.get(words[0], set()) & set(words))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_commands_and_code_of_a_page_work(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "examples").symlink_to(ROOT / "docs" / "examples")
    names: dict[str, object] = {"__name__": "__main__"}
    for block in blocks(page.read_text(encoding="utf-8")):
        for command in commands(block):
            run_command(command)
        if block.language == "python":
            padding = "\n" * block.line  # so that a traceback names the line of the page
            exec(compile(padding + block.text, str(page), "exec"), names)


def test_links_between_pages_and_to_files_lead_somewhere():
    for page in PAGES:
        text = re.sub(r"`[^`]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
            if not re.match(r"[a-z]+:", target):
                assert (page.parent / target).exists(), f"{page.name} links to {target}"


EXAMPLE = """Intro
```python
x = 1
```
```console
$ armside laser --radius 3 \\
    --quiet
Results in runs/
$ make run
armside bench kinematics  # minutes
```
```text
armside nothing
```
"""


def test_blocks_and_commands_are_found_as_a_reader_would():
    python, console, text = blocks(EXAMPLE)
    assert (python.language, python.text, python.line) == ("python", "x = 1\n", 2)
    assert commands(python) == commands(text) == []
    first, second = commands(console)
    assert shlex.split(first) == ["armside", "laser", "--radius", "3", "--quiet"]
    assert second.startswith("armside bench kinematics")


def test_a_command_that_does_not_work_is_noticed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError, match="--radius 0"):
        run_command("armside laser --radius 0")
