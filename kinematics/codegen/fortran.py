"""Fortran 2003: one subroutine with C binding, matrices are Fortran matrices."""

import textwrap

import sympy as sp

from ..equations.program import Block, Program
from .printing import Printer, header, step_lines


class FortranPrinter(Printer):
    def _number(self, value: float) -> str:
        return f"{value!r}_dp"

    def _print_Integer(self, expr: sp.Integer) -> str:
        return f"{int(expr)}.0_dp"

    def _sign_of(self, x: str) -> str:
        return f"(merge(1.0_dp, 0.0_dp, {x} > 0) - merge(1.0_dp, 0.0_dp, {x} < 0))"


def write(program: Program, name: str) -> dict[str, str]:
    printer, blocks = FortranPrinter(), [*program.inputs, *program.outputs]
    symbols = [s for b in program.inputs for s in b.elements] + [s for s, _ in program.steps]
    lines = [f"! {line}".rstrip() for line in header(program, name)]
    arguments = ", ".join(block.name for block in blocks)
    lines += [
        f"subroutine {name}({arguments}) bind(c)",
        "  use, intrinsic :: iso_c_binding, only: dp => c_double",
        "  implicit none",
    ]
    lines += [f"  real(dp), intent(in) :: {b.name}({b.shape[0]})" for b in program.inputs]
    for block in program.outputs:
        lines.append(f"  real(dp), intent(out) :: {block.name}({', '.join(map(str, block.shape))})")
    lines += [f"  real(dp) :: {symbol}" for symbol in symbols]
    lines += [
        f"  {symbol} = {block.name}({i + 1})"
        for block in program.inputs
        for i, symbol in enumerate(block.elements)
    ]
    lines += step_lines(program, printer, "  {} = {}")
    for block in program.outputs:
        lines += [
            f"  {block.name}({_index(block, i)}) = {printer.doprint(element)}"
            for i, element in enumerate(block.elements)
        ]
    lines.append(f"end subroutine {name}")
    return {f"{name}.f90": "\n".join(map(_continued, lines)) + "\n"}


def _index(block: Block, i: int) -> str:
    """Subscripts of element i in row-major order."""
    if len(block.shape) == 1:
        return f"{i + 1}"
    return f"{i // block.shape[1] + 1}, {i % block.shape[1] + 1}"


def _continued(line: str) -> str:
    """A Fortran line of at most 132 characters, cut at spaces."""
    if len(line) <= 130 or line.startswith("!"):
        return line
    parts = textwrap.wrap(line, 120, break_long_words=False, break_on_hyphens=False)
    return " &\n      ".join(parts)
