"""A report as pages: Markdown beside the figures, and one HTML file that needs nothing else."""

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path

from ..shell.console import cell
from .report import FIGURES, Check, Grid, Section

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


def _verdict(check: Check) -> str:
    return "holds" if check.holds else "FAILS"


def count(sections: Sequence[Section]) -> str:
    """How many checks hold, in words."""
    checks = [check for section in sections for check in section.checks]
    holding = sum(check.holds for check in checks)
    return f"{holding} of {len(checks)} comparisons with the thesis hold"


def markdown(title: str, sections: Sequence[Section]) -> str:
    """The report for reading as text; figures are files beside it."""
    lines = [f"# {title}", "", f"{count(sections)}.", ""]
    for section in sections:
        lines += [f"## {section.title}", "", section.caption, ""]
        lines += [f"![{section.title}]({FIGURES}/{name})\n" for name in section.figures]
        if section.checks:
            lines += _pipes(_check_columns(), [_check_row(check) for check in section.checks])
            lines += [
                f"- {check.id} fails: {check.reason}"
                for check in section.checks
                if check.reason and not check.holds
            ]
            lines.append("")
        for grid in section.grids:
            rows = [[cell(value) for value in row] for row in grid.rows]
            lines += [f"**{grid.title}**", "", *_pipes(grid.columns, rows)]
        lines += [f"*{_made(section)}*", ""]
    return "\n".join(lines)


def _check_columns() -> list[str]:
    return ["", "what", "thesis", "ours", "band", "verdict"]


def _check_row(check: Check) -> list[str]:
    return [
        check.id,
        check.statement,
        check.thesis,
        cell(float(check.ours)),
        check.band,
        _verdict(check),
    ]


def _pipes(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    grid = [list(columns), ["---"] * len(columns), *rows]
    return ["| " + " | ".join(w.replace("|", "\\|") for w in words) + " |" for words in grid] + [""]


def _made(section: Section) -> str:
    return ", ".join(f"{name} {value}" for name, value in section.made_with.items())


def html(title: str, sections: Sequence[Section], figures: Path) -> str:
    """The report as one file: figures inline, no script, no network."""
    contents = "".join(
        f'<li><a href="#s{i}">{escape(section.title)}</a></li>'
        for i, section in enumerate(sections)
    )
    body = "".join(_section_html(i, section, figures) for i, section in enumerate(sections))
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title>"
        '<meta name="viewport" content="width=device-width">'
        f"<style>{STYLE}</style></head>\n<body><h1>{escape(title)}</h1>\n"
        f"<p>{escape(count(sections))}.</p><ul>{contents}</ul>\n{body}</body></html>\n"
    )


def _section_html(i: int, section: Section, figures: Path) -> str:
    parts = [f'<h2 id="s{i}">{escape(section.title)}</h2>', f"<p>{escape(section.caption)}</p>"]
    for name in section.figures:
        data = base64.b64encode((figures / name).read_bytes()).decode("ascii")
        alt = escape(section.title, quote=True)
        parts.append(f'<p><img alt="{alt}" src="data:image/png;base64,{data}"></p>')
    if section.checks:
        parts.append(_checks_html(section.checks))
    parts += [_grid_html(grid) for grid in section.grids]
    parts.append(f'<p class="made">{escape(_made(section))}</p>\n')
    return "\n".join(parts)


def _checks_html(checks: Sequence[Check]) -> str:
    rows = []
    for check in checks:
        words = _check_row(check)
        verdict = words.pop()
        cells = "".join(
            f'<td class="number">{escape(word)}</td>' if i == 3 else f"<td>{escape(word)}</td>"
            for i, word in enumerate(words)
        )
        kind = "holds" if check.holds else "fails"
        why = f'<div class="reason">{escape(check.reason)}</div>' if kind == "fails" else ""
        rows.append(f'<tr>{cells}<td class="{kind}">{verdict}{why}</td></tr>')
    return _table(_check_columns(), rows)


def _grid_html(grid: Grid) -> str:
    rows = [
        "<tr>"
        + "".join(
            f"<td>{escape(value)}</td>"
            if isinstance(value, str)
            else f'<td class="number">{escape(cell(value))}</td>'
            for value in row
        )
        + "</tr>"
        for row in grid.rows
    ]
    return f"<p><b>{escape(grid.title)}</b></p>{_table(grid.columns, rows)}"


def _table(columns: Sequence[str], rows: Sequence[str]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>'
        f"{''.join(rows)}</tbody></table></div>"
    )
