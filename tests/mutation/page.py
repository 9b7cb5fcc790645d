"""The page docs/mutation.md: score by package, and the fate of every mutant."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence

from .month import Fate, section
from .mutant import ALL, Mutant, counted
from .session import Trial

_INTRODUCTION = """\
# Faults that the tests notice

Written by `python -m tests.mutation page`. Each line is a deliberate fault in one file, chosen for
what a user would care about; `make mutants` puts them in one at a time, in a copy of the tree, and
runs the nearest tests, then those of the package. A fault is noticed when a test fails. Faults
marked † were once measured to go unnoticed by the tests closest to them. Generic mutants are those
of the operators of [Cosmic Ray](https://cosmic-ray.readthedocs.io).
"""
_GENERIC = re.compile(r"## Generic mutants.*?(?=^## (?!Generic mutants))", re.DOTALL | re.MULTILINE)


def page(
    mutants: Sequence[Mutant],
    months: Mapping[str, Sequence[Fate]],
    results: Mapping[str, Trial],
    before: str = "",
) -> str:
    """Markdown of the page. Mutants without a result count as not tried.

    before: the page as it is, whose curated faults stay where no result of any is known.
    """
    generic = "\n".join(section(month, rows) for month, rows in sorted(months.items()))
    if before and not any(mutant.key in results for mutant in mutants):
        without = _GENERIC.sub("", before)
        return without.replace("## Equivalent,", f"{generic}\n## Equivalent,", 1)
    parts = [_INTRODUCTION + _commits(mutants, results)]
    parts.append(_scores("Curated faults", mutants, results))
    parts += [generic] if generic else []
    parts.append(_equivalent(mutants))
    for package in ALL:
        own = [mutant for mutant in counted(mutants) if mutant.package == package]
        parts.append(f"## {package}\n\n" + _table(own, results))
    return "\n".join(parts)


def _commits(mutants: Sequence[Mutant], results: Mapping[str, Trial]) -> str:
    """Sentence that says of which commits the results are; empty where none is known."""
    tried = [results[mutant.key].commit for mutant in counted(mutants) if mutant.key in results]
    found = [f"{commit} ({n} faults)" for commit, n in Counter(tried).most_common() if commit]
    return f"\nResults are of the code and the tests of {', '.join(found)}.\n" if found else ""


def score(mutants: Sequence[Mutant], results: Mapping[str, Trial]) -> tuple[int, int]:
    """Numbers of killed mutants and of tried ones, equivalent ones left out."""
    tried = [results[mutant.key] for mutant in counted(mutants) if mutant.key in results]
    return sum(outcome.killed for outcome in tried), len(tried)


def _scores(title: str, mutants: Sequence[Mutant], results: Mapping[str, Trial]) -> str:
    lines = [f"## {title}\n", "| package | noticed | of | | not tried |", "|---|---|---|---|---|"]
    for name, packages in (*((p, (p,)) for p in ALL), ("all", ALL)):
        own = [m for m in counted(mutants) if m.package in packages]
        killed, tried = score(own, results)
        if own:
            rate = f"{100 * killed // tried} %" if tried else "-"
            lines.append(f"| {name} | {killed} | {tried} | {rate} | {len(own) - tried} |")
    return "\n".join(lines) + "\n"


def _equivalent(mutants: Sequence[Mutant]) -> str:
    lines = [f"- {m.file}: {m.name}. {m.equivalent}" for m in mutants if m.equivalent]
    return "## Equivalent, not counted\n\n" + ("\n".join(lines) or "None.") + "\n"


def _table(mutants: Sequence[Mutant], results: Mapping[str, Trial]) -> str:
    lines = ["| file | fault | noticed by |", "| --- | --- | --- |"]
    for mutant in mutants:
        fate = _fate(mutant, results.get(mutant.key))
        name = f"{mutant.name} (†)" if mutant.found else mutant.name
        lines.append(f"| {_file(mutant)} | {name} | {fate} |")
    return "\n".join(lines) + "\n"


def _file(mutant: Mutant) -> str:
    return mutant.file.removeprefix(f"{mutant.package}/")


def _fate(mutant: Mutant, outcome: Trial | None) -> str:
    if outcome is None:
        return "not tried"
    if outcome.killed:
        # a parameter of a test may contain what ends a cell
        return outcome.by.removeprefix("tests/").partition("[")[0]
    return f"**survives**{': ' if mutant.survives else ''}{mutant.survives}"
