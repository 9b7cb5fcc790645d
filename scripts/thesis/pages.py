"""A report as pages: Markdown beside the figures, and one HTML file that needs nothing else."""

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any

from armside.sim.evaluation.check import Check

from ..shell.console import cell
from .report import FIGURES, Section

COLUMNS = ("", "what", "thesis", "ours", "band", "verdict")
"""Columns of a table of checks."""

STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h2 { margin-top: 3rem; border-top: 1px solid #8886; padding-top: 1rem; }
img { max-width: 100%; background: white; }
table { border-collapse: collapse; font-size: .88rem; margin: .8rem 0; }
th, td { text-align: left; padding: .2rem .7rem; border-bottom: 1px solid #8884; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.scroll { overflow-x: auto; }
.holds { color: #00795c; } .fails { color: #c04000; font-weight: 700; }
.reason, .made { font-size: .85rem; opacity: .8; }
"""


def count(sections: Sequence[Section]) -> str:
    """Number of checks that hold, in words: those with the thesis, then those of our own."""
    checks = [(check, section.source) for section in sections for check in section.checks]
    thesis, papers = (
        [c for c, source in checks if c.thesis and source == of] for of in ("thesis", "paper")
    )
    own = [c for c, _ in checks if not c.thesis]
    held = {" with the thesis": thesis, " with papers": papers}
    held[" that it does not have" if thesis else ""] = own
    counted = [
        f"{sum(c.holds for c in of)} of {len(of)} comparisons{w}" for w, of in held.items() if of
    ]
    return f"{' and '.join(counted) or '0 of 0 comparisons'} hold"


def columns(sections: Iterable[Section]) -> tuple[str, ...]:
    """`COLUMNS`, with the source that all sections have in place of the thesis."""
    sources = {section.source for section in sections}
    return tuple("paper" if c == "thesis" and sources == {"paper"} else c for c in COLUMNS)


def check_row(check: Check) -> list[str]:
    """The cells of a check, below `COLUMNS`."""
    ours = cell(check.ours)
    return [check.id, check.statement, check.thesis, ours, check.band, check.verdict]


def markdown(title: str, sections: Sequence[Section]) -> str:
    """The report for reading as text; figures are files beside it."""
    lines = [f"# {title}", "", f"{count(sections)}.", ""]
    for section in sections:
        lines += [f"## {section.title}", "", section.caption, ""]
        lines += [f"![{section.title}]({FIGURES}/{name})\n" for name in section.figures]
        if section.checks:
            lines += _pipes(columns([section]), [check_row(check) for check in section.checks])
            failed = [check for check in section.checks if check.reason and not check.holds]
            lines += [f"- {check.id} fails: {check.reason}" for check in failed]
            lines.append("")
        for table in section.tables:
            lines += [f"**{table.title}**", "", *_pipes(table.columns, table.rows)]
        lines += [f"*{_made(section)}*", ""]
    return "\n".join(lines)


def _pipes(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    grid = [head, ["---"] * len(head), *([cell(value) for value in row] for row in rows)]
    return ["| " + " | ".join(w.replace("|", "\\|") for w in words) + " |" for words in grid] + [""]


def _made(section: Section) -> str:
    return ", ".join(f"{name} {value}" for name, value in section.made_with.items())


def html(title: str, sections: Sequence[Section], figures: Path) -> str:
    """The report as one file: figures inline, no script, no network."""
    titles = enumerate(escape(section.title) for section in sections)
    contents = "".join(f'<li><a href="#s{i}">{title}</a></li>' for i, title in titles)
    body = "".join(_section_html(i, section, figures) for i, section in enumerate(sections))
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title>"
        '<meta name="viewport" content="width=device-width">'
        f"<style>{STYLE}</style></head>\n<body><h1>{escape(title)}</h1>\n<p>{escape(count(sections))}.</p><ul>{contents}</ul>\n{body}</body></html>\n"
    )


def _section_html(i: int, section: Section, figures: Path) -> str:
    parts = [f'<h2 id="s{i}">{escape(section.title)}</h2>', f"<p>{escape(section.caption)}</p>"]
    for name in section.figures:
        data = base64.b64encode((figures / name).read_bytes()).decode("ascii")
        alt = escape(section.title, quote=True)
        parts.append(f'<p><img alt="{alt}" src="data:image/png;base64,{data}"></p>')
    if section.checks:
        parts.append(_rows_html(columns([section]), map(_check_html, section.checks)))
    for table in section.tables:
        cells = (((v, not isinstance(v, str)) for v in row) for row in table.rows)
        rows = ("".join(_cell_html(v, number=number) for v, number in row) for row in cells)
        parts.append(f"<p><b>{escape(table.title)}</b></p>{_rows_html(table.columns, rows)}")
    parts.append(f'<p class="made">{escape(_made(section))}</p>\n')
    return "\n".join(parts)


def _check_html(check: Check) -> str:
    *words, verdict = check_row(check)
    cells = "".join(_cell_html(word, number=i == 3) for i, word in enumerate(words))
    kind = "holds" if check.holds else "fails"
    why = "" if check.holds else f'<div class="reason">{escape(check.reason)}</div>'
    return f'{cells}<td class="{kind}">{verdict}{why}</td>'


def _cell_html(value: Any, *, number: bool) -> str:
    kind = ' class="number"' if number else ""
    return f"<td{kind}>{escape(cell(value))}</td>"


def _rows_html(head: Sequence[str], rows: Iterable[str]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f'<div class="scroll">{table}</div>'
