"""What the type checker is told about SymPy, whose own annotations are partial.

An element of a SymPy matrix is annotated as an element, a list or a matrix; a derivative as an
array. We know which it is, and say so once, here, instead of at each place.
"""

from typing import Any, TypeAlias

import sympy as sp

Expression: TypeAlias = Any
"""A SymPy expression."""
SymbolicMatrix: TypeAlias = Any
"""A SymPy matrix."""


_PARTS_OF_PI = 12


def exact(value: Any) -> Expression:
    """A length or factor: the decimal fraction that a float was written as."""
    if isinstance(value, sp.Expr):
        return value
    return sp.Integer(value) if isinstance(value, int) else sp.Rational(repr(float(value)))


def exact_angle(value: Any) -> Expression:
    """An angle: a float that is a multiple of pi/12 to its last bits becomes that multiple."""
    if isinstance(value, sp.Expr):
        return value
    parts = float(value) / float(sp.pi) * _PARTS_OF_PI
    if value and abs(parts - round(parts)) <= 4e-16 * max(1.0, abs(parts)):
        return sp.Rational(round(parts), _PARTS_OF_PI) * sp.pi
    return exact(value)
