"""Commands and code of README and the docs work as written.

A block marked `python` is run; the blocks of one page share their names, as a reader's would.
In blocks marked `sh` or `console` each line that starts with `armside` is run, with or without
`$ ` before it. Commands that take minutes are only parsed. A line that several pages show and
that reads no file is run once, and each page goes on with the folder that it wrote. A block marked
`toml` whose first line is `# NAME.toml` is written to that file.

In CI this is the whole of it. Else cuts that are learned make one update, springs are identified in
few steps, one twin stands for those of the pages, and of the lines of a block that show options of
one command the first is run.
"""

import os
import re
import shlex
import shutil
from pathlib import Path
from typing import NamedTuple

import pytest
from tests import evidence

from armside.scripts import cli
from armside.scripts.shell.parser import parse

ROOT = Path(__file__).parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
TAKES_MINUTES = {"compare", "reproduce"}
WHOLE = bool(os.environ.get("ARMSIDE_CI"))
"""Run lines as they stand; else those of half a minute are left to their commands' tests."""
TWIN_OF = "2001"
"""Individual of the twin that `commissioned` makes."""
SHOWS = {"robot": {"view"}, "serve": {"serve"}, "replay": {"--web", "--png", "--video"}}
"""Commands that open a window, serve until they are stopped, or need a GL library: their own tests
run them."""
SEVERAL_PAGES = "armside commission --individual 7 --cuts 4 --out twin"
"""Run once for all pages and workers: it makes its folder from nothing else."""
NAMED = re.compile(r"# (\w+\.toml)\n")
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
    if not WHOLE:
        words = small(words)
    if words and (takes_minutes(words) or only_shows(words)):
        parse(words, cli.COMMANDS, cli.load)
    else:
        assert cli.main(words) == 0, command


def small(words: list[str]) -> list[str]:
    """The words with one update at most, and the individual of the shared twin."""
    if words[:1] in (["laser"], ["cut"]) and not {"--iterations", "--plan-only"} & set(words):
        words = [*words, "--iterations", "1"]
    if words[:1] == ["learn"] and "--iterations" in words:
        at = words.index("--iterations") + 1
        words = [*words[:at], str(min(int(words[at]), 1)), *words[at + 1 :]]
    if "--twin" in words:
        at = words.index("--individual") + 1
        words = [*words[:at], TWIN_OF, *words[at + 1 :]]
    return words


def copy_twin(command: str, commissioned: Path) -> None:
    """Put the shared twin where a page's commissioning would write its own."""
    words = shlex.split(command, comments=True)[1:]
    parse(words, cli.COMMANDS, cli.load)
    shutil.copytree(commissioned / "twin", words[words.index("--out") + 1])


def run_once(command: str, made_once) -> None:
    """Run a command whose folder other pages use too, or copy the folder that it wrote before."""
    out = Path(shlex.split(command)[-1])

    def make(folder: Path) -> None:
        run_command(command)
        shutil.copytree(out, folder)

    done = made_once(f"page-{out}", make)
    if not out.exists():
        shutil.copytree(done, out, ignore=lambda *_: {"made"})


def reads_what_no_line_wrote(command: str, earlier: list[str]) -> bool:
    """True where a line names a file in the folder of an earlier one that was only parsed."""
    typed = [shlex.split(line, comments=True)[1:] for line in earlier]
    unwritten = {w[w.index("--out") + 1] for w in typed if "--out" in w and takes_minutes(w)}
    words = shlex.split(command, comments=True)
    return any(word.split("/")[0] in unwritten for word in words if "/" in word)


def is_a_variant(lines: list[str]) -> bool:
    """True where a line before the last has run its command, which leaves nothing by a name."""
    *before, last = (shlex.split(line, comments=True)[1:] for line in lines)
    verb = slice(0, 2 if last[0] == "robot" else 1)
    ran = [words for words in before if not (takes_minutes(words) or only_shows(words))]
    return "--out" not in last and any(words[verb] == last[verb] for words in ran)


def takes_minutes(words: list[str]) -> bool:
    """True for what is only parsed; in CI those of half a minute are run."""
    identifies = "estimate" in words and "--identification" not in words
    measures = words[0] == "gears" and "large" in words
    learns_in_a_twin = words[0] == "cut" and "--twin" in words
    long = identifies or measures or learns_in_a_twin
    return words[0] in TAKES_MINUTES or (not WHOLE and long)


def only_shows(words: list[str]) -> bool:
    """True for a command without a result; a replay without a file to write opens a window."""
    opens_window = words[0] == "replay" and "--save" not in words
    return opens_window or bool(SHOWS.get(words[0], set()) & set(words))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
@pytest.mark.usefixtures("quick_identification")
def test_commands_and_code_of_a_page_work(page, tmp_path, monkeypatch, request):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "examples").symlink_to(ROOT / "docs" / "examples")
    names: dict[str, object] = {"__name__": "__main__"}
    earlier: list[str] = []
    for block in blocks(page.read_text(encoding="utf-8")):
        of_block: list[str] = []
        for command in commands(block):
            of_block.append(command)
            if reads_what_no_line_wrote(command, earlier):
                pass
            elif not WHOLE and is_a_variant(of_block):
                parse(shlex.split(command, comments=True)[1:], cli.COMMANDS, cli.load)
            elif not WHOLE and command.startswith("armside commission "):
                copy_twin(command, request.getfixturevalue("commissioned"))
            elif command == SEVERAL_PAGES:
                run_once(command, request.getfixturevalue("made_once"))
            else:
                run_command(command)
            earlier.append(command)
        if block.language == "toml" and (named := NAMED.match(block.text)):
            (tmp_path / named[1]).write_text(block.text, encoding="utf-8")
        if block.language == "python":
            padding = "\n" * block.line  # so that a traceback names the line of the page
            exec(compile(padding + block.text, str(page), "exec"), names)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_lines_of_make_have_targets_and_names_that_exist(page):
    text = page.read_text(encoding="utf-8")
    lines = re.findall(
        r"^(?:\$ )?(make [a-z].*)$", "\n".join(b.text for b in blocks(text)), re.MULTILINE
    )
    quoted = re.findall(r"`(make (?:claims|bench|pictures)\b[^`]*)`", text)
    for line in (*lines, *(line for line in quoted if "..." not in line)):
        assert evidence.is_made(line), line


def test_a_line_is_left_out_only_if_it_reads_what_was_not_written():
    parsed = "armside reproduce 9 --out judged"
    assert reads_what_no_line_wrote("armside laser --gears judged/gears.toml  # read", [parsed])
    assert not reads_what_no_line_wrote("armside laser --gears judged/gears.toml", [])
    assert not reads_what_no_line_wrote("armside laser --from cut/a", [parsed])
    ran = "armside robot new --out judged"
    assert not reads_what_no_line_wrote("armside laser --gears judged/gears.toml", [ran])


def anchors(page: Path) -> set[str]:
    """Of its headings, as GitHub and MyST name them."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    headings = re.findall(r"^#+ +(.+?) *$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_links_between_pages_and_to_files_lead_somewhere():
    for page in PAGES:
        text = re.sub(r"`[^`]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
        for target, heading in re.findall(r"\]\(([^)#\s]*)#?([^)\s]*)[^)]*\)", text):
            if not re.match(r"[a-z]+:", target):
                there = page.parent / target if target else page
                assert there.exists(), f"{page.name} links to {target}"
                known = not heading or there.suffix != ".md" or heading in anchors(there)
                assert known, f"{page.name} links to {target}#{heading}"


def test_a_line_of_several_pages_is_run_once_and_fails_on_every_page(
    tmp_path, monkeypatch, made_once
):
    lines = []

    def writes(command):
        lines.append(command)
        assert "broken" not in command
        Path("tried").mkdir()

    monkeypatch.setattr(f"{__name__}.run_command", writes)
    for page, line in (("a", "--broken"), ("b", "--broken"), ("c", ""), ("d", "")):
        (tmp_path / page).mkdir()
        monkeypatch.chdir(tmp_path / page)
        command = f"armside commission {line} --out tried"
        if line:
            with pytest.raises(AssertionError):
                run_once(command, made_once)
        else:
            run_once(command, made_once)
            assert Path("tried").is_dir()
    assert len(lines) == 3


def test_the_line_of_several_pages_is_theirs():
    shown = [command for page in PAGES for b in blocks(page.read_text()) for command in commands(b)]
    assert shown.count(SEVERAL_PAGES) >= 2


EXAMPLE = """Intro
```python
x = 1
```
```console
$ armside laser --radius 3 \\
    --quiet
Results in runs/
$ make run
armside reproduce 9  # minutes
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
    assert second.startswith("armside reproduce 9")


def test_a_command_that_does_not_work_is_noticed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError, match="--radius 0"):
        run_command("armside laser --radius 0")
