"""The generic mutants of a month: what became of each, beside the reasons given by hand."""

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from .mutant import PACKAGES, Mutant
from .session import Trial

MONTHS = Path(__file__).parent / "months"

_ABOUT = """\
Drawn at random over the files of the packages by the seed of the month, and tried with the four
files of tests nearest to each alone. `noticed at first`: before any test was written for them.
"""


@dataclass(frozen=True, kw_only=True)
class Fate:
    """Of a generic mutant."""

    file: str
    name: str
    """Operator, line and its text."""
    noticed: str = ""
    """The test that noticed it."""
    found: bool = False
    """It was not noticed when it was first tried."""
    equivalent: str = ""
    """Reason why it is no fault; such a mutant is not counted."""
    survives: str = ""
    """Reason why no test notices it."""
    untried: bool = False


def fates(month: str, folder: Path = MONTHS) -> list[Fate]:
    """What is kept of a month; empty for one that was not tried."""
    file = folder / f"{month}.toml"
    data = tomllib.loads(file.read_text(encoding="utf-8")) if file.exists() else {"mutants": []}
    return [Fate(**row) for row in data["mutants"]]


def updated(
    before: Sequence[Fate], mutants: Sequence[Mutant], results: Mapping[str, Trial]
) -> list[Fate]:
    """Fates with the outcomes of a run; reasons, and mutants that were not tried again, stay."""
    kept = {(fate.file, fate.name): fate for fate in before}
    for mutant in mutants:
        key = (mutant.file, mutant.name)
        fate = kept.setdefault(key, Fate(file=mutant.file, name=mutant.name, untried=True))
        if outcome := results.get(mutant.key):
            noticed = outcome.by if outcome.killed else ""
            found = fate.found or (fate.untried and not noticed)
            kept[key] = replace(fate, noticed=noticed, found=found, untried=False)
    return list(kept.values())


def write(month: str, rows: Sequence[Fate], folder: Path = MONTHS) -> None:
    """Keep the fates of a month, a line each."""
    lines = []
    for row in rows:
        given = {key: value for key, value in asdict(row).items() if value}
        pairs = (f"{k} = {json.dumps(v, ensure_ascii=False)}" for k, v in given.items())
        lines.append(f"  {{{', '.join(pairs)}}},\n")
    folder.mkdir(exist_ok=True)
    text = "mutants = [\n" + "".join(lines) + "]\n"
    (folder / f"{month}.toml").write_text(text, encoding="utf-8")


def with_reasons(mutants: Sequence[Mutant], rows: Sequence[Fate]) -> list[Mutant]:
    """The mutants with the reasons that were given for them, wherever their lines are now."""
    known = {_place(row): row for row in rows if row.equivalent or row.survives}
    found = ((mutant, known.get(_place(mutant))) for mutant in mutants)
    return [
        replace(m, equivalent=row.equivalent, survives=row.survives) if row else m
        for m, row in found
    ]


def _place(one: Mutant | Fate) -> tuple[str, str]:
    return one.file, re.sub(r" in line \d+", "", one.name)


def section(month: str, rows: Sequence[Fate]) -> str:
    """Markdown: noticed at first and now by package, and what is equivalent or survives."""
    head = "| package | noticed at first | noticed | of | | equivalent | not tried |"
    lines = [f"## Generic mutants of {month}\n", _ABOUT, head, "|---|---|---|---|---|---|---|"]
    for name, packages in (*((p, (p,)) for p in PACKAGES), ("all", PACKAGES)):
        own = [row for row in rows if row.file.partition("/")[0] in packages]
        if real := [row for row in own if not (row.equivalent or row.untried)]:
            now = sum(bool(row.noticed) for row in real)
            first = sum(not row.found for row in real)
            untried = sum(row.untried for row in own)
            counts = f"{first} | {now} | {len(real)} | {100 * now // len(real)} %"
            lines.append(f"| {name} | {counts} | {len(own) - len(real) - untried} | {untried} |")
    lines += _listed("Equivalent", {row: row.equivalent for row in rows if row.equivalent})
    lines += _listed("Not noticed", {row: row.survives for row in rows if row.survives})
    known = ("noticed", "equivalent", "survives", "untried")
    left = [row for row in rows if not any(getattr(row, name) for name in known)]
    lines += _listed("Not judged yet", dict.fromkeys(left, ""))
    return "\n".join(lines) + "\n"


def _listed(title: str, reasons: Mapping[Fate, str]) -> list[str]:
    """A line for each mutant, or for those with one reason."""
    lines = ["", f"{title}:", ""] if reasons else []
    for reason in dict.fromkeys(reasons.values()):
        own = [row for row, given in reasons.items() if given == reason]
        if len(own) > 2 and reason:
            lines.append(
                f"- {len(own)} mutants of {', '.join(sorted({r.file for r in own}))}. {reason}"
            )
        else:
            lines += [f"- {r.file}: `{' '.join(r.name.split())}`. {reason}".rstrip() for r in own]
    return lines
