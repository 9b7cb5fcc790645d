"""Straight-line programs: named intermediates and outputs, the form all generated code comes from.

A `Tape` names each intermediate as it is built, so a recursion over the links never expands; the
same expression, or its negative, gets one name. `program_of` makes a program of finished ones, and
shares their common parts. Thesis 4.2.2, 4.4.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import wraps
from typing import Any, Concatenate, NamedTuple, ParamSpec, TypeVar

import sympy as sp

from ..dh import Robot
from ..expressions.symbols import Expression, SymbolicMatrix, code_names, internal
from .inertial_model import InertialModel


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
    def computed(self) -> list[Expression]:
        """Expressions of the steps, then those of the outputs."""
        return [e for _, e in self.steps] + [e for b in self.outputs for e in b.elements]

    @property
    def operations(self) -> int:
        """Arithmetic operations and function calls, as SymPy counts them."""
        return int(sp.count_ops(self.computed))

    def expressions(self) -> tuple[Expression, ...]:
        """All output elements with the names substituted back: full expressions of the inputs."""
        known: dict[Expression, Expression] = {}
        for symbol, expression in self.steps:
            known[symbol] = expression.xreplace(known)
        return tuple(e.xreplace(known) for argument in self.outputs for e in argument.elements)


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
        notes: tuple[str, ...],
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


_GENERATED = re.compile(r"(x|(phi|psi)d{0,2}|tau)\d+(_rate)?")
Subject = TypeVar("Subject", Robot, InertialModel)
Arguments = ParamSpec("Arguments")
Builder = Callable[Concatenate[Subject, Arguments], StraightLineProgram]


def separated(build: Builder[Subject, Arguments]) -> Builder[Subject, Arguments]:
    """A builder of programs whose robot or model keeps its parameters apart from generated names.

    Each parameter that is equal to a variable of generated code becomes another symbol with its
    name; `codegen` then gives the two different names.
    """

    @wraps(build)
    def with_own_names(
        subject: Subject, *arguments: Arguments.args, **named: Arguments.kwargs
    ) -> StraightLineProgram:
        own = {
            s: internal(s.name)
            for s in subject.free_symbols
            if s == sp.Symbol(s.name, real=True) and _GENERATED.fullmatch(s.name)
        }
        return build(_renamed(subject, own) if own else subject, *arguments, **named)

    return with_own_names


def _renamed(value: Any, own: dict[Any, Any]) -> Any:
    """A value with other symbols, in tuples and records as well."""
    if isinstance(value, tuple):
        return tuple(_renamed(each, own) for each in value)
    if is_dataclass(value) and not isinstance(value, type):
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
        return replace(value, **{name: _renamed(part, own) for name, part in parts.items()})
    return value.xreplace(own) if isinstance(value, sp.Basic) else value


def program_of(name: str, expression: Any, notes: tuple[str, ...] = ()) -> StraightLineProgram:
    """A program that computes an expression or matrix from its own variables, common parts shared.

    Functions of time and their derivatives get code names (phi_1(t) -> phi_1, then phi_1d and
    phi_1dd). The one input `q` holds all variables in the order that its header comment states.
    """
    whole = expression if isinstance(expression, sp.MatrixBase) else [expression]
    matrix: SymbolicMatrix = sp.Matrix(whole)
    plain = matrix.xreplace(code_names(list(matrix)))
    variables = tuple(sorted(plain.free_symbols, key=_order))
    shape = plain.shape if plain.shape[1] > 1 else (plain.shape[0],)
    steps, shared = sp.cse(list(plain), sp.numbered_symbols("x", real=True), order="none")
    order = f"q: {', '.join(map(str, variables))}"
    inputs = (Argument("q", (len(variables),), variables),)
    out = Argument("result", shape, tuple(shared))
    return StraightLineProgram(name, inputs, tuple(steps), (out,), (*notes, order))


def _order(symbol: sp.Symbol) -> tuple[str, int, int]:
    """phi_1, phi_2, ..., then first and second derivatives."""
    name = str(symbol)
    stem = name.rstrip("d") if "_" in name else name
    head, _, tail = stem.rpartition("_")
    orders = len(name) - len(stem)
    return (head, orders, int(tail)) if tail.isdigit() else (name, 0, 0)
