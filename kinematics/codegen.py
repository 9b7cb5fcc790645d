"""Straight-line programs as text: the numba functions that the project itself runs."""

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from .program import Block, Program


class _Printer(PythonCodePrinter):
    """Plain arithmetic on names: small powers as products, fractions as floats."""

    def _print_Rational(self, expr: sp.Rational) -> str:
        return repr(float(expr))

    def _print_Pi(self, expr: sp.Expr) -> str:
        return repr(float(expr))

    def _print_Pow(self, expr: sp.Expr, rational: bool = False) -> str:
        base, exponent = expr.as_base_exp()
        if exponent.is_Integer and 2 <= exponent <= 3:
            factor = self.parenthesize(base, 100)
            return "(" + "*".join([factor] * int(exponent)) + ")"
        return super()._print_Pow(expr, rational=rational)


def _names(block: Block) -> str:
    """`a, b, c = phi`: bind the elements of an input to their symbols, one line each."""
    return "".join(f"    {s} = {block.name}[{i}]\n" for i, s in enumerate(block.elements))


def _stores(printer: _Printer, block: Block) -> str:
    """Write each element of an output."""
    lines = []
    for position, element in enumerate(block.elements):
        index: list[int] = []
        rest = position
        for size in reversed(block.shape):
            rest, i = divmod(rest, size)
            index.insert(0, i)
        where = ", ".join(map(str, index))
        lines.append(f"    {block.name}[{where}] = {printer.doprint(element)}\n")
    return "".join(lines)


def _array(dimensions: int) -> str:
    return "f8[" + ":, " * (dimensions - 1) + "::1]"


def _check(blocks: tuple[Block, ...], batched: bool) -> str:
    """Shapes are checked where it costs nothing: a wrong one would read past an array."""
    tests = []
    for block in blocks:
        for axis, size in enumerate(block.shape):
            tests.append(f"{block.name}.shape[{axis + batched}] != {size}")
        if batched:
            tests.append(f"{block.name}.shape[0] != {blocks[0].name}.shape[0]")
    return "    if " + " or ".join(tests) + ":\n        raise ValueError\n"


def numba_module(program: Program) -> str:
    """Module with `one(inputs..., outputs...)` and `many`, whose arrays have a leading axis."""
    printer = _Printer({"fully_qualified_modules": False})
    blocks = (*program.inputs, *program.outputs)
    arguments = ", ".join(block.name for block in blocks)
    body = "".join(_names(block) for block in program.inputs)
    body += "".join(f"    {symbol} = {printer.doprint(e)}\n" for symbol, e in program.steps)
    body += "".join(_stores(printer, block) for block in program.outputs)
    one = ", ".join(_array(len(b.shape)) for b in blocks)
    many = ", ".join(_array(len(b.shape) + 1) for b in blocks)
    rows = ", ".join(f"{b.name}[k]" for b in blocks)
    head = "\n".join((f"{program.name}, generated: do not edit.", "", *program.notes))
    return (
        f'"""{head}\n"""\n\n'
        "from math import cos, sin, sqrt, tanh\n\n"
        "from numba import njit\n\n\n"
        f'@njit(cache=True, error_model="numpy")\ndef _{program.name}({arguments}):\n{body}\n\n'
        f'@njit("void({one})", cache=True, error_model="numpy")\n'
        f"def one({arguments}):\n{_check(blocks, False)}    _{program.name}({arguments})\n\n\n"
        f'@njit("void({many})", cache=True, error_model="numpy", nogil=True)\n'
        f"def many({arguments}):\n{_check(blocks, True)}"
        f"    for k in range({blocks[0].name}.shape[0]):\n        _{program.name}({rows})\n"
    )
