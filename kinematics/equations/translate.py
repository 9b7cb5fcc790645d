"""Any symbolic expression as a program, ready for `codegen`. Thesis 4.2.2, 4.4."""

from typing import Any

import sympy as sp

from ..expressions.exact import SymbolicMatrix
from ..expressions.symbols import code_names
from .program import Argument, StraightLineProgram


def program_of(name: str, expression: Any, notes: tuple[str, ...] = ()) -> StraightLineProgram:
    """A program that computes an expression or matrix from its own variables.

    Functions of time and their derivatives get code names (phi_1(t) -> phi_1, then phi_1d and
    phi_1dd). The one input `q` holds all variables in the order that its header comment states.
    """
    whole = expression if isinstance(expression, sp.MatrixBase) else [expression]
    matrix: SymbolicMatrix = sp.Matrix(whole)
    plain = matrix.xreplace(code_names(list(matrix)))
    variables = tuple(sorted(plain.free_symbols, key=_order))
    shape = plain.shape if plain.shape[1] > 1 else (plain.shape[0],)
    inputs = [Argument("q", (len(variables),), variables)]
    order = f"q: {', '.join(map(str, variables))}"
    return StraightLineProgram.from_expressions(
        name, inputs, [Argument("result", shape, tuple(plain))], (*notes, order)
    )


def _order(symbol: sp.Symbol) -> tuple[str, int, int]:
    """phi_1, phi_2, ..., then first and second derivatives."""
    name = str(symbol)
    stem = name.rstrip("d") if "_" in name else name
    head, _, tail = stem.rpartition("_")
    orders = len(name) - len(stem)
    return (head, orders, int(tail)) if tail.isdigit() else (name, 0, 0)
