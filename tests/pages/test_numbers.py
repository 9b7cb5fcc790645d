"""Numbers with a unit in README and guides have a source: a mark, or a place in declared.toml."""

import re
import tomllib
from pathlib import Path

import pytest

from ..house import RECORDS
from ._engine import ROOT, without_marks

DECLARED = tomllib.loads(Path(__file__).with_name("declared.toml").read_text(encoding="utf-8"))
GUIDES = [p for p in sorted((ROOT / "docs").glob("*.md")) if p.stem not in RECORDS]
PAGES = {page.name: page for page in (ROOT / "README.md", *GUIDES)}
NUMBER = re.compile(
    r"(?<![\w.`/#-])\d(?:[\d,.]*\d)?(?:e-?\d+)?\s?(?:%|µm|um|mm|m?rad|k?Hz|m?s|seconds)(?![\w/²])"
)
"""Speeds [mm/s] are asked for, never found, and acceleration limits [m/s²] likewise."""
HASH = re.compile(r"(?<![\w#/.-])(?=[0-9a-f]*[a-f])(?=[0-9a-f]*\d)[0-9a-f]{7,40}(?![\w.-])")
EXAMPLES = {  # of a page: how many of its numbers have no source
    "12 µm, 3.5 % and 0.7 Hz of 5 mm": 4,
    "<!--cure.rms-->12<!--/--> µm": 0,
    "`--speed 5 mm` at 40 mm/s, axis 3, k = 5\n```sh\n12 mm\n```\n[x](a-12 mm.md)": 0,
}


def prose(text: str) -> str:
    """A page without marks, code, targets of links and texts of pictures; single spaces."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    text = re.sub(r"`[^`]*`|!\[[^\]]*\]|(?<=\])\([^)]*\)", "", without_marks(text))
    return " ".join(text.split())


def without_source(name: str, text: str) -> list[str]:
    """Numbers of a page that have none."""
    said = prose(text)
    for reason in DECLARED:
        for phrase in DECLARED[reason].get(name, ()):
            said = said.replace(phrase, "")
    return NUMBER.findall(said)


@pytest.mark.parametrize("name", PAGES)
def test_numbers_with_a_unit_have_a_source(name):
    assert without_source(name, PAGES[name].read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("reason", DECLARED)
def test_a_declared_phrase_stands_in_its_page_and_has_a_number(reason):
    for name, phrases in DECLARED[reason].items():
        said = prose(PAGES[name].read_text(encoding="utf-8"))
        for phrase in phrases:
            assert phrase in said, name
            assert NUMBER.search(phrase), phrase


@pytest.mark.parametrize("text", EXAMPLES)
def test_a_number_without_a_mark_is_found(text):
    assert len(without_source("", text)) == EXAMPLES[text]


def test_a_readme_with_one_number_more_is_refused():
    text = PAGES["README.md"].read_text(encoding="utf-8")
    assert without_source("README.md", text) == []
    assert without_source("README.md", f"{text}\nIt ends at 13 µm.") == ["13 µm"]


def test_pages_name_no_commit_of_ours():
    """Those of others stand beside the repository's name; findings.md has a column of them."""
    generated = {"mutation.md", "findings.md"}
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")):
        if page.name not in generated:
            said = " ".join(page.read_text(encoding="utf-8").split())
            ours = re.sub(r" code [0-9a-f]{16}\.|\w/[\w-]+,? \(?(?:commit )?[0-9a-f]+", "", said)
            assert not HASH.search(ours), page
