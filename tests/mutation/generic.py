"""A seeded sample of the generic mutants of Cosmic Ray: numbers, comparisons, operators."""

import ast
import os
import random
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

from .mutant import PACKAGES, ROOT, Mutant

_LEFT_OUT = ("Decorator", "Exception", "Variable", "BitOr")
"""Operators that remove decorators (numba's change no result) or mutate unions of types."""
_FILES = 4
"""Test files that a mutant is tried with first."""
_NAMED = (ast.FunctionDef, ast.ClassDef)
_PICTURES = ("scripts/figures", "scripts/viewers")


def sample(size: int, seed: int) -> list[Mutant]:
    """Mutants drawn file by file and operator by operator, none twice."""
    rng, found = random.Random(seed), {}
    files = [
        path
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
        if not str(path.relative_to(ROOT)).startswith(_PICTURES)
    ]
    while len(found) < size:
        path = rng.choice(files)
        text = path.read_text(encoding="utf-8")
        if choices := list(_mutations(text)):
            name, occurrence, line = rng.choice(choices)
            mutant = _mutant(str(path.relative_to(ROOT)), text, name, occurrence, line)
            found[mutant.key] = mutant
    return list(found.values())


def _mutations(text: str) -> Iterator[tuple[str, int, int]]:
    """Operator, occurrence and line of each generic mutation."""
    nodes = list(ast_nodes(get_ast(text)))
    for name in operator_names():
        operator = get_operator(name)
        if operator.arguments() or any(word in name for word in _LEFT_OUT):
            continue
        positions = (p for node in nodes for p in operator().mutation_positions(node))
        for occurrence, ((line, _), _) in enumerate(positions):
            yield name, occurrence, line


def _mutant(file: str, text: str, operator: str, occurrence: int, line: int) -> Mutant:
    mutated = mutate_code(text, get_operator(operator)(), occurrence)
    return Mutant(
        name=f"{operator.removeprefix('core/')} in line {line}: {text.splitlines()[line - 1]}",
        file=file,
        old=text,
        new=mutated,
        tests=_nearest(file),
        operator=operator,
    )


def _nearest(file: str) -> tuple[str, ...]:
    """The test file of a module, and those that mention names of it that few others do."""
    path = Path(file)
    names = {
        n.name for n in ast.parse((ROOT / file).read_text("utf-8")).body if isinstance(n, _NAMED)
    }
    public = {name for name in names if not name.startswith("_")} | {path.stem}

    def rank(test: Path) -> tuple[bool, float, int]:
        own = test == Path("tests") / path.parent / f"test_{path.stem}.py"
        room = len(os.path.commonpath((path.parent, test.parent.relative_to("tests"))))
        return own, bool(room) * sum(1 / _uses()[n] for n in public & _words(test)), room

    return tuple(map(str, sorted(_test_files(), key=rank, reverse=True)[:_FILES]))


@cache
def _uses() -> Counter[str]:
    """Number of test files that mention a name."""
    return Counter(name for test in _test_files() for name in _words(test))


@cache
def _test_files() -> list[Path]:
    return [
        path.relative_to(ROOT)
        for package in PACKAGES
        for path in sorted((ROOT / "tests" / package).rglob("test_*.py"))
    ]


@cache
def _words(test: Path) -> set[str]:
    return set(re.findall(r"\w+", (ROOT / test).read_text("utf-8")))
