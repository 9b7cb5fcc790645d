"""Fortran 2003: one subroutine with C binding, matrices are Fortran matrices."""

import textwrap

import sympy as sp

from ..equations.program import StraightLineProgram
from .printing import Printer, header, input_elements, step_lines, subscripts


class FortranPrinter(Printer):
    def _number(self, value: float) -> str:
        return f"{value!r}_dp"

    def _print_Integer(self, expr: sp.Integer) -> str:
        return f"{int(expr)}.0_dp"

    def _sign_of(self, x: str) -> str:
        return f"merge(1.0_dp, merge(-1.0_dp, {x}, {x} < 0), {x} > 0)"


def write(program: StraightLineProgram, name: str) -> dict[str, str]:
    printer, inputs = FortranPrinter(), input_elements(program)
    symbols = [symbol for symbol, _, _ in inputs] + [symbol for symbol, _ in program.steps]
    lines = [f"! {line}".rstrip() for line in header(program, name)]
    lines += [
        f"subroutine {name}({', '.join(b.name for b in program.arguments)}) bind(c)",
        "  use, intrinsic :: iso_c_binding, only: dp => c_double",
        "  implicit none",
    ]
    lines += [f"  real(dp), intent(in) :: {b.name}({b.shape[0]})" for b in program.inputs]
    for b in program.outputs:
        lines.append(f"  real(dp), intent(out) :: {b.name}({', '.join(map(str, b.shape))})")
    lines += [f"  real(dp) :: {symbol}" for symbol in symbols]
    lines += [f"  {symbol} = {argument}({i + 1})" for symbol, argument, i in inputs]
    lines += step_lines(program, printer, "  {} = {}")
    lines += [
        f"  {b.name}({index}) = {printer.doprint(element)}"
        for b in program.outputs
        for index, element in zip(subscripts(b.shape, 1), b.elements, strict=True)
    ]
    lines.append(f"end subroutine {name}")
    return {f"{name}.f90": "\n".join(map(_continued, lines)) + "\n"}


def _continued(line: str) -> str:
    """A Fortran line of at most 132 characters, cut at spaces."""
    if len(line) <= 130 or line.startswith("!"):
        return line
    parts = textwrap.wrap(line, 120, break_long_words=False, break_on_hyphens=False)
    return " &\n      ".join(parts)
