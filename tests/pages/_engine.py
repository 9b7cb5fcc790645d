"""Numbers of README and docs, each made by a command: sources, stored results, marks in the pages.

A page marks a number by its id, `<!--source.name-->13<!--/-->`, which a reader does not see, and a
table likewise around its head and rows. The manifest says of each source which command prints it,
and of each name which expression of the command's JSON it is. Results are stored with the digest
of the code that they depend on. The last line of a page names the sources that are older than
today's code.
"""

import ast
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from .. import evidence
from ..house import PACKAGES, House
from ..house import source as python_source

ROOT = Path(__file__).parents[2]
MANIFEST = Path(__file__).with_name("manifest.toml")
RESULTS = Path(__file__).with_name("results.json")
UNKNOWN = "unknown"
"""Version, code or data of what is older than the stamps."""
DATA = (".xml", ".toml", ".json", ".npz")
"""Files beside the code that a result depends on, in the folders of the code and in assets."""
_MARK = re.compile(r"<!--([\w-]+(?:\.[\w-]+)+)-->(.*?)<!--/-->", re.DOTALL)
_MADE_BY = re.compile(
    r"^Written by `make claims.*with armside (\S+?),.*?(?: code ([0-9a-f]{16}))?\.$", re.M
)
_IMAGE = re.compile(r"!\[[^\]]*\]\([\w/]*\bimages/([\w-]+\.png)\)")
_STAMP = re.compile(r"\n*<!--stamp-->.*?<!--/-->\n*\Z", re.DOTALL)


@dataclass(frozen=True)
class Source:
    """Command lines of armside, run one after the other in one folder; or the page of a claim."""

    name: str
    lines: tuple[str, ...]
    """The last one prints JSON; or `make claims NAME=...`, the line of a page, as the only one."""
    values: Mapping[str, str]
    """Expression and format by name, "1e6 * iterations[0].arm_rms | .1f"; of a claim those of its
    `cells`, a list of rows."""
    drawn_by: Path | None = None
    """Module of a picture, whose lines make what it shows."""
    seed: str = "0"

    @property
    def claim(self) -> str:
        """Name of the claim, if it is one."""
        made = self.lines[0].partition("make claims NAME=")[2]
        return made.partition(" ")[0]

    @property
    def entry(self) -> tuple[Path, ...]:
        """Files of the commands or of the claim, and of the picture."""
        own = (self.drawn_by,) if self.drawn_by else ()
        if self.claim:
            return (claim_file(self.claim), *own)
        words = (line.split()[0].replace("-", "_") for line in self.lines if line[:5] != "make ")
        return (*(ROOT / f"scripts/commands/{word}.py" for word in words), *own)

    def run(self) -> dict[str, Any]:
        """Values by name. Raises RuntimeError with what a command printed where it fails."""
        if self.claim:
            return evaluated({"cells": table(claim_page(self.claim))}, self.values)
        with tempfile.TemporaryDirectory(prefix="armside-") as folder:
            os.symlink(ROOT / "docs", Path(folder) / "docs")
            output = ""
            for i, line in enumerate(self.lines):
                last = ["--json"] if i == len(self.lines) - 1 else []
                done = subprocess.run(
                    [sys.executable, "-m", "armside", *line.split(), *last],
                    cwd=folder, capture_output=True, text=True, check=False,
                )  # fmt: skip
                if done.returncode != 0:
                    raise RuntimeError(f"armside {line}: {done.stderr.strip()}")
                output = done.stdout
        return evaluated(json.loads(output), self.values)


@dataclass(frozen=True)
class Result:
    """What a source gave, and by which code."""

    version: str
    code: str
    lines: tuple[str, ...]
    values: Mapping[str, Any]


class Entry(dict[str, Any]):
    """JSON object whose members are attributes."""

    __getattr__ = dict.__getitem__


def _of_each(table: Mapping[str, Any]) -> dict[str, str]:
    """Values `NAME-KEY` of the names of `each`, which stand for {} in `values-of-each`."""
    return {
        f"{name}-{key}": text.replace("{}", name)
        for name in table.get("each", ())
        for key, text in table["values-of-each"].items()
    }


def evaluated(found: Mapping[str, Any], values: Mapping[str, str]) -> dict[str, Any]:
    """The expressions of a manifest on the JSON of a command."""
    names = json.loads(json.dumps(found), object_hook=Entry)
    exact = {"np": np, "max": max, "min": min, "len": len, "__builtins__": {}}
    return {
        name: np.asarray(eval(text.rpartition("|")[0], exact | names)).tolist()
        for name, text in values.items()
    }


def sources(manifest: Path = MANIFEST) -> dict[str, Source]:
    """Sources of a manifest by name."""
    tables = tomllib.loads(manifest.read_text(encoding="utf-8"))
    return {
        name: Source(name, tuple(table["lines"]), {**table.get("values", {}), **_of_each(table)})
        for name, table in tables.items()
    }


def results(file: Path = RESULTS) -> dict[str, Result]:
    """Stored results by the name of their source."""
    stored = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    return {
        name: Result(r["version"], r["code"], tuple(r["lines"]), r["values"])
        for name, r in stored.items()
    }


def store(found: Mapping[str, Result], file: Path = RESULTS) -> None:
    """Write results, by name."""
    plain = {name: vars(result) for name, result in sorted(found.items())}
    file.write_text(json.dumps(plain, indent=1) + "\n", encoding="utf-8")


def claim_file(name: str) -> Path:
    """Module of a claim."""
    return Path(str(evidence.module("claims", name).__file__))


def claims() -> list[str]:
    """Names of the claims that have a page."""
    return sorted(p.stem for p in (ROOT / "docs/claims").glob("*.md") if p.stem != "index")


def claim_page(name: str) -> str:
    """Text of the page of a claim."""
    return (ROOT / "docs/claims" / f"{name}.md").read_text(encoding="utf-8")


def table(text: str) -> list[list[float | str]]:
    """Rows of the first table of a page; cells that are numbers as such."""
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    return [[_cell(cell.strip()) for cell in line[1:-1].split(" | ")] for line in lines[2:]]


def _cell(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def made(source: Source) -> Result:
    """Run a source with today's code, or read what the page of a claim has."""
    by = by_claim(source.claim) if source.claim else made_with_today(source)
    return Result(*by, source.lines, source.run())


def by_claim(name: str) -> tuple[str, str]:
    """Version and code that the page of a claim was written with."""
    by = _MADE_BY.search(claim_page(name))
    return (by[1], by[2] or UNKNOWN) if by else (UNKNOWN, UNKNOWN)


def made_with_today(source: Source) -> tuple[str, str]:
    """Today's version and code of a source."""
    return version("armside"), code(source.entry)


def code(entry: Sequence[Path], root: Path = ROOT) -> str:
    """Digest of the code that files import, directly or through others, and of the data beside it.

    Comments and docstrings do not count.
    """
    house = _house(root)
    todo, seen = [root / file.relative_to(ROOT) for file in entry], set[Path]()
    while todo:
        if (file := todo.pop()) not in seen:
            seen.add(file)
            todo += house.imports[file]
    folders = {file.parent for file in seen} | {root / "assets"}
    data = {f for folder in folders for f in folder.iterdir() if f.suffix in DATA}
    hashed = hashlib.sha256()
    for file in sorted(seen | data):
        content = _bare(file) if file in seen else file.read_bytes()
        hashed.update(file.relative_to(root).as_posix().encode() + b"\0" + content)
    return hashed.hexdigest()[:16]


@cache
def _house(root: Path) -> House:
    return House(root, (*PACKAGES, "tests"))


class _Bare(ast.NodeTransformer):
    """Takes texts that stand alone, such as docstrings, out of a tree."""

    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        return None if isinstance(node.value, ast.Constant) else node


@cache
def _bare(file: Path) -> bytes:
    tree = ast.parse(python_source(file))
    return ast.dump(_Bare().visit(tree)).encode()


def shown(value: Any, form: str, before: str) -> str:
    """A value in its format.

    Rows get the head of the table that stands in the page, and a format for each column.
    """
    if not isinstance(value, list):
        return f"{value:{form}}"
    head = before.strip().splitlines()[:2]
    rows = [" | ".join(f"{v:{f}}" for v, f in zip(r, form.split(), strict=True)) for r in value]
    return "\n".join(["", *head, *(f"| {row} |" for row in rows), ""])


def rendered(
    text: str, known: Mapping[str, Source], found: Mapping[str, Result], old: Callable[[str], bool]
) -> str:
    """A page with the numbers of stored results, and its stamp.

    old: true for a source that is older than today's code. Raises ValueError for an id that the
    manifest does not have or whose source has no result.
    """
    used: dict[str, None] = {}

    def number(match: re.Match[str]) -> str:
        name, _, value = match[1].partition(".")
        if name not in found or value not in found[name].values:
            raise ValueError(f"no result for {match[1]}: make pages NAME={name}")
        used[name] = None
        form = known[name].values[value].rpartition("|")[2].strip()
        return f"<!--{match[1]}-->{shown(found[name].values[value], form, match[2])}<!--/-->"

    text = _MARK.sub(number, text)
    used |= dict.fromkeys(name for name in images(text) if name in found)
    stale = [name for name in used if old(name)]
    versions = ", ".join(sorted({found[name].version for name in stale}))
    return stamped(text, f"of version {versions}: {', '.join(stale)}" if stale else "")


def stamped(text: str, older: str) -> str:
    """A page whose last line tells what of it is older than today's code; without it if empty."""
    text = _STAMP.sub("\n", text)
    if not older:
        return text
    return f"{text.rstrip()}\n\n<!--stamp-->Older than today's code, {older}.<!--/-->\n"


def claim_stamped(name: str) -> str:
    """The page of a claim, with its age."""
    by = _MADE_BY.search(text := claim_page(name))
    fresh = by is not None and by[2] == code([claim_file(name)])
    return stamped(text, "" if fresh else f"of version {by[1] if by else '0.1.0'}")


def marks(text: str) -> list[str]:
    """Ids of the numbers of a page."""
    return [match[1] for match in _MARK.finditer(text)]


def without_marks(text: str) -> str:
    """A page without its numbers that have an id."""
    return _MARK.sub("#", text)


def images(text: str) -> list[str]:
    """File names of the pictures of a page."""
    return _IMAGE.findall(text)


def pages() -> list[Path]:
    """Pages that have numbers with an id, or pictures."""
    found = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
    texts = ((page, page.read_text(encoding="utf-8")) for page in found)
    return [page for page, text in texts if marks(text) or images(text)]
