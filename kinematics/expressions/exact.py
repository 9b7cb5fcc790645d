"""Exact SymPy numbers of floats, and type aliases for SymPy, whose own annotations are partial."""

from typing import Any, TypeAlias

import sympy as sp

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
