"""A seeded sample of the generic mutants of Cosmic Ray: numbers, comparisons, operators."""

import random
from collections.abc import Iterator

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

from .mutant import PACKAGES, ROOT, Mutant

_LEFT_OUT = ("Decorator", "Exception", "Variable", "BitOr")
"""Operators that remove decorators (numba's change no result) or mutate unions of types."""
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
        tests=(_nearest(file),),
        operator=operator,
    )


def _nearest(file: str) -> str:
    """The test file of a module, or the folder of tests of its room."""
    folder, _, stem = file.removesuffix(".py").rpartition("/")
    while folder:
        for path in (f"tests/{folder}/test_{stem}.py", f"tests/{folder}"):
            if (ROOT / path).exists():
                return path
        folder, _, stem = folder.rpartition("/")
    return "tests"
