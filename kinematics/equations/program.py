"""Straight-line programs: named intermediates and outputs, the form all generated code comes from.

A `Tape` names each intermediate as it is built, so a recursion over the links never expands; the
same expression, or its negative, gets one name. `StraightLineProgram.from_expressions` shares the
common parts of finished expressions.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import sympy as sp

from ..expressions.exact import Expression


class Argument(NamedTuple):
    """An array argument: its name, shape and elements in row-major order."""

    name: str
    shape: tuple[int, ...]
    elements: tuple[Expression, ...]


@dataclass(frozen=True)
class StraightLineProgram:
    """`steps` in order, each a new name and its expression; then `outputs`. Inputs are symbols."""

    name: str
    inputs: tuple[Argument, ...]
    steps: tuple[tuple[sp.Symbol, Expression], ...]
    outputs: tuple[Argument, ...]
    notes: tuple[str, ...] = ()
    """Robot, convention, units and orders, for the reader of generated code."""

    @property
    def arguments(self) -> tuple[Argument, ...]:
        """Inputs, then outputs."""
        return self.inputs + self.outputs

    @property
    def operations(self) -> int:
        """Arithmetic operations and function calls, as SymPy counts them."""
        expressions = [expression for _, expression in self.steps]
        return int(sp.count_ops(expressions + [e for b in self.outputs for e in b.elements]))

    def expressions(self) -> tuple[Expression, ...]:
        """All output elements with the names substituted back: full expressions of the inputs."""
        known: dict[Expression, Expression] = {}
        for symbol, expression in self.steps:
            known[symbol] = expression.xreplace(known)
        return tuple(e.xreplace(known) for argument in self.outputs for e in argument.elements)

    @classmethod
    def from_expressions(
        cls,
        name: str,
        inputs: Sequence[Argument],
        outputs: Sequence[Argument],
        notes: tuple[str, ...] = (),
    ) -> "StraightLineProgram":
        """Share the common parts of finished expressions."""
        flat = [element for argument in outputs for element in argument.elements]
        steps, reduced = sp.cse(flat, symbols=sp.numbered_symbols("x", real=True), order="none")
        rest = iter(reduced)
        shared = tuple(b._replace(elements=tuple(next(rest) for _ in b.elements)) for b in outputs)
        return cls(name, tuple(inputs), tuple(steps), shared, notes)


class Tape:
    """Gives a name to each intermediate expression, once."""

    def __init__(self, program: StraightLineProgram | None = None) -> None:
        """An empty tape, or one that continues the steps of a program."""
        self.steps: list[tuple[sp.Symbol, Expression]] = list(program.steps) if program else []
        self._names = {expression: symbol for symbol, expression in self.steps}
        self._next = 1 + max((int(s.name[1:]) for s, _ in self.steps), default=-1)

    def __call__(self, expression: Expression) -> Expression:
        """The expression itself if it is a number, a symbol or its negative; else its name."""
        expression = sp.sympify(expression)
        if expression.is_Atom or (-expression).is_Atom:
            return expression
        if expression.could_extract_minus_sign():
            return -self(-expression)
        if (found := self._names.get(expression)) is not None:
            return found
        symbol = sp.Symbol(f"x{self._next}", real=True)
        self._next += 1
        self.steps.append((symbol, expression))
        self._names[expression] = symbol
        return symbol

    def program(
        self,
        name: str,
        inputs: Iterable[Argument],
        outputs: Iterable[Argument],
        notes: tuple[str, ...] = (),
    ) -> StraightLineProgram:
        """The tape so far as a program; steps that no output needs are dropped."""
        outputs = tuple(outputs)
        needed = set().union(*(e.free_symbols for argument in outputs for e in argument.elements))
        kept = []
        for symbol, expression in reversed(self.steps):
            if symbol in needed:
                needed |= expression.free_symbols
                kept.append((symbol, expression))
        return StraightLineProgram(name, tuple(inputs), tuple(reversed(kept)), outputs, notes)
