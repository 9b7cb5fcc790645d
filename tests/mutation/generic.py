"""A seeded sample of the generic mutants of Cosmic Ray: numbers, comparisons, operators."""

import ast
import os
import random
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names
from tests.house import House

from .mutant import PACKAGES, ROOT, Mutant

_LEFT_OUT = ("Decorator", "Exception", "Variable", "BitOr")
"""Operators that remove decorators (numba's change no result) or mutate unions of types."""
_FILES = 4
"""Test files that a mutant is tried with first."""
_HERE = 5
"""Weight of the name of the definition that is mutated; others of its file have one."""
_USER = 0.5
"""Weight of a name of a file that imports the mutated one, and of a test of another package."""
_NAMED = (ast.FunctionDef, ast.ClassDef)
_PICTURES = ("scripts/figures", "scripts/viewers")


def sample(size: int, seed: int) -> list[Mutant]:
    """Mutants drawn file by file and operator by operator, none twice, each a program.

    What cannot be a fault is not drawn: a change that leaves the program as it is once annotations,
    tests of `TYPE_CHECKING` and the marks `*` and `/` in signatures are taken out.
    """
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
            mutated = mutate_code(text, get_operator(name)(), occurrence) or text
            if _program(mutated) not in (_program(text), ""):
                mutant = _mutant(str(path.relative_to(ROOT)), text, mutated, name, line)
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


class _Run(ast.NodeTransformer):
    """What of a program is run: types and the marks in signatures are not."""

    def visit_arg(self, node: ast.arg) -> ast.AST:
        return ast.arg(node.arg)

    def visit_arguments(self, node: ast.arguments) -> ast.AST:
        names = [*node.posonlyargs, *node.args, *node.kwonlyargs]
        node.posonlyargs, node.args, node.kwonlyargs = [], names, []
        node.defaults, node.kw_defaults = [*node.defaults, *filter(None, node.kw_defaults)], []
        return self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.returns = None
        return self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)

    def visit_If(self, node: ast.If) -> ast.AST:
        if "TYPE_CHECKING" in ast.unparse(node.test):
            node.test = ast.Constant(None)
        return self.generic_visit(node)


def _program(text: str) -> str:
    """What is run of a text; empty where it is no Python."""
    try:
        return ast.dump(_Run().visit(ast.parse(text)))
    except SyntaxError:
        return ""


def _mutant(file: str, text: str, mutated: str, operator: str, line: int) -> Mutant:
    return Mutant(
        name=f"{operator.removeprefix('core/')} in line {line}: {text.splitlines()[line - 1]}",
        file=file,
        old=text,
        new=mutated,
        tests=_nearest(file, line),
        operator=operator,
    )


def _nearest(file: str, line: int) -> tuple[str, ...]:
    """The test file of a module, and those that mention what few others do: above all the
    definition with the line, others of the file, and those of files that import it."""
    path, names = Path(file), Counter[str]()
    for user in _house().imports:
        if ROOT / file in _house().imports[user]:
            names |= Counter(dict.fromkeys(_public(user), _USER))
    names |= Counter(dict.fromkeys(_public(ROOT / file), 1))
    for node in ast.parse((ROOT / file).read_text("utf-8")).body:
        if isinstance(node, _NAMED) and node.lineno <= line <= (node.end_lineno or 0):
            names[node.name] = _HERE

    def rank(test: Path) -> tuple[bool, float, int]:
        own = test == Path("tests") / path.parent / f"test_{path.stem}.py"
        room = len(os.path.commonpath((path.parent, test.parent.relative_to("tests"))))
        near = 1.0 if room else _USER
        return own, near * sum(names[n] / _uses()[n] for n in _words(test) & set(names)), room

    return tuple(map(str, sorted(_test_files(), key=rank, reverse=True)[:_FILES]))


def _public(file: Path) -> set[str]:
    """Public names that a module defines, and its own."""
    body = _house().trees[file].body
    names = {node.name for node in body if isinstance(node, _NAMED)}
    return {name for name in names if not name.startswith("_")} | {file.stem}


@cache
def _house() -> House:
    return House(ROOT)


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
    """Names in the code of a test, and strings of one word, such as those of a command line."""
    found = set[str]()
    for node in ast.walk(ast.parse((ROOT / test).read_text("utf-8"))):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name):
                found.add(name)
            case ast.ImportFrom(module=str(name)) | ast.alias(name=name) | ast.Constant(str(name)):
                found.update(name.split(".") if " " not in name else ())
    return found
