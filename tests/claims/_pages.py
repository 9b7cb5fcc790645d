"""Pages of claims in docs/claims, and the index of them."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from armside.scripts.shell.console import cell
from armside.sim.evaluation.check import Table

INDEX = """\
# Claims

What this project says about its robots, over many seeds. Each page is written by its command and
has every row behind its verdicts.
`make help` lists the names; a claim is a file of `tests/claims`.

"""
TOCTREE = "```{toctree}\n:hidden:\n:glob:\n\n*\n```\n"


def command(name: str, n_seeds: int, seed: int) -> str:
    """The command line of a page."""
    return f"make claims NAME={name} SEEDS={n_seeds} SEED={seed}"


def page(table: Table, made_by: str, versions: Mapping[str, str]) -> str:
    """The command that made it, the verdicts, and every row.

    versions: of libraries by name, and the digest of the code.
    """
    listed = ", ".join(f"{name} {number}" for name, number in versions.items())
    verdicts = [f"- {'holds' if v.holds else '**fails**'}: {v.statement}" for v in table.verdicts]
    head = [f"# {table.title}", "", f"Written by `{made_by}` with {listed}.", ""]
    return "\n".join([*head, *verdicts, "", *_pipes(table.columns, table.rows)])


def index(folder: Path) -> str:
    """A row for each page of a folder: claim, verdict, command."""
    pages = {p.stem: p.read_text("utf-8") for p in folder.glob("*.md") if p.stem != "index"}
    rows = [_entry(name, text) for name, text in sorted(pages.items())]
    return INDEX + "\n".join(_pipes(("claim", "statements that hold", "command"), rows)) + TOCTREE


def _entry(name: str, text: str) -> tuple[str, str, str]:
    title, made_by = (
        re.findall(pattern, text, re.MULTILINE)[0]
        for pattern in (r"^# (.*)$", r"^Written by `(.*?)`")
    )
    holds, fails = (len(re.findall(rf"^- {w}:", text, re.M)) for w in ("holds", r"\*\*fails\*\*"))
    return f"[{title}]({name}.md)", f"{holds} of {holds + fails}", f"`{made_by}`"


def _pipes(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    grid = [columns, ["---"] * len(columns), *([cell(value) for value in row] for row in rows)]
    return ["| " + " | ".join(w.replace("|", "\\|") for w in words) + " |" for words in grid] + [""]
