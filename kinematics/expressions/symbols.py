"""Symbols with an index, functions of time, their derivatives, and exact numbers of floats.

`symbol("phi", 1)` is phi_1 and `moving("phi", 1)` is phi_1(t). The two are different variables, as
are phi(t) and phi_1(t): nothing here works by the text of a name.
"""

from collections.abc import Iterable
from functools import cache
from itertools import pairwise
from typing import Any, TypeAlias

import sympy as sp
from sympy.core.function import AppliedUndef

Expression: TypeAlias = Any
"""A SymPy expression."""
SymbolicMatrix: TypeAlias = Any
"""A SymPy matrix."""

_PARTS_OF_PI = 12


def exact(value: Any) -> Expression:
    """The decimal fraction that a float (a length or factor) was written as; expressions stay."""
    if isinstance(value, sp.Expr):
        return value
    return sp.Integer(value) if isinstance(value, int) else sp.Rational(repr(float(value)))


def exact_angle(value: Any) -> Expression:
    """Like `exact`, but a float that is a multiple of pi/12 to its last bits becomes that."""
    if isinstance(value, sp.Expr):
        return value
    parts = float(value) / float(sp.pi) * _PARTS_OF_PI
    if value and abs(parts - round(parts)) <= 4e-16 * max(1.0, abs(parts)):
        return sp.Rational(round(parts), _PARTS_OF_PI) * sp.pi
    return exact(value)


t = sp.Symbol("t", real=True)
"""Time [s]."""


def symbol(name: str, index: int | None = None) -> sp.Symbol:
    """A constant, such as phi or phi_1."""
    return sp.Symbol(_label(name, index), real=True)


def moving(name: str, index: int | None = None) -> Any:
    """A function of time, such as phi(t) or phi_1(t)."""
    return sp.Function(_label(name, index), real=True)(t)


def _label(name: str, index: int | None) -> str:
    return name if index is None else f"{name}_{index}"


@cache
def internal(name: str) -> sp.Symbol:
    """A symbol with this name that is equal to no symbol of a user's; one for each name."""
    return sp.Dummy(name, real=True)


def functions_of_time(expressions: Iterable[Expression]) -> tuple[Any, ...]:
    """Every function of t in some expressions, in the order of their names."""
    found = set().union(*(e.atoms(AppliedUndef) for e in map(sp.sympify, expressions)))
    return tuple(sorted((f for f in found if f.args == (t,)), key=_natural))


def _natural(expression: Any) -> tuple[str, int]:
    name = expression.func.__name__ if isinstance(expression, AppliedUndef) else str(expression)
    head, _, tail = name.rpartition("_")
    return (head, int(tail)) if tail.isdigit() else (name, -1)


def differentiate(expression: Any, variable: Any) -> Any:
    """Partial derivative with respect to a symbol or a function of time such as q_1(t).

    d q_1(t)/dt, q(t) and q_2(t) are other variables and count as constants. Thesis (4.6), (4.7).
    """
    held = sp.Dummy("held", real=True)
    expression = sp.sympify(expression)
    derivatives = {d: sp.Dummy() for d in expression.atoms(sp.Derivative)}
    plain = expression.xreplace(derivatives).xreplace({variable: held})
    result = plain.diff(held).xreplace({held: variable})
    return result.xreplace({dummy: d for d, dummy in derivatives.items()})


def code_names(expressions: Iterable[Any]) -> dict[Any, sp.Symbol]:
    """Names for generated code: q_1(t) -> q_1, its derivatives q_1d, q_1dd. Thesis 4.2.2.

    Apply with `expression.xreplace(...)`; derivatives come first so that none is left half named.
    Raises ValueError: two variables get the same name, such as phi_1(t) and the constant phi_1.
    """
    names: dict[Any, sp.Symbol] = {}
    expressions = list(expressions)
    for expression in expressions:
        for derivative in expression.atoms(sp.Derivative):
            order = derivative.derivative_count
            function = derivative.expr.func.__name__
            names[derivative] = sp.Symbol(function + "d" * int(order), real=True)
    for function in functions_of_time(expressions):
        names[function] = sp.Symbol(function.func.__name__, real=True)
    constants = set().union(*(e.free_symbols for e in expressions)) - {t}
    used = sorted([*(str(s) for s in names.values()), *map(str, constants)])
    if twice := {a for a, b in pairwise(used) if a == b}:
        raise ValueError(f"two variables are called {', '.join(sorted(twice))} in code: rename one")
    return names
