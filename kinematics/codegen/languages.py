"""Writers of C99, Fortran 2003, MATLAB (and Octave), LaTeX and Python, one function each.

C has no allocation, `const double *` in and `double *` out; a Fortran subroutine has C binding;
vectors of MATLAB are columns; Python is the module that `compile` runs.
"""

import textwrap
from collections.abc import Callable, Sequence

import numpy as np
import sympy as sp

from armside.arrays import Array

from ..equations.program import Argument, StraightLineProgram
from .printing import Printer, distinct, header, input_elements, output_lines, step_lines


def c_files(program: StraightLineProgram, name: str) -> dict[str, str]:
    printer = Printer()
    arguments = [f"const double *{b.name}" for b in program.inputs]
    arguments += [f"double *{b.name}" for b in program.outputs]
    signature = f"void {name}({', '.join(arguments)})"
    comment = "\n".join(f" * {line}".rstrip() for line in header(program, name))
    comment = f"/*\n{comment}\n * matrices are row by row\n */\n"
    used = set().union(*(e.free_symbols for e in program.computed))
    lines = [
        f"    const double {symbol} = {argument}[{i}];"
        for symbol, argument, i in input_elements(program)
        if symbol in used
    ]
    lines += [f"    (void){b.name};" for b in program.inputs if not used.intersection(b.elements)]
    lines += step_lines(program, printer, "    const double {} = {};")
    lines += [
        f"    {b.name}[{i}] = {printer.doprint(element)};"
        for b in program.outputs
        for i, element in enumerate(b.elements)
    ]
    guard, body = f"{name.upper()}_H", "\n".join(lines)
    declaration = (
        f"{comment}#ifndef {guard}\n#define {guard}\n\n"
        f'#ifdef __cplusplus\nextern "C" {{\n#endif\n\n{signature};\n\n'
        f"#ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )
    includes = f'#include "{name}.h"\n\n#include <math.h>\n\n'
    return {
        f"{name}.h": declaration,
        f"{name}.c": f"{comment}{includes}{signature}\n{{\n{body}\n}}\n",
    }


class FortranPrinter(Printer):
    def _number(self, value: float) -> str:
        return f"{value!r}_dp"

    def _print_Integer(self, expr: sp.Integer) -> str:
        return f"{int(expr)}.0_dp"

    def _sign_of(self, x: str) -> str:
        return f"merge(1.0_dp, merge(-1.0_dp, {x}, {x} < 0), {x} > 0)"


def fortran_files(program: StraightLineProgram, name: str) -> dict[str, str]:
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
    for b in program.outputs:
        lines += output_lines(b, printer, "  {}({}) = {}", 1)
    lines.append(f"end subroutine {name}")
    return {f"{name}.f90": "\n".join(map(_continued, lines)) + "\n"}


def _continued(line: str) -> str:
    """A Fortran line of at most 132 characters, cut at spaces."""
    if len(line) <= 130 or line.startswith("!"):
        return line
    parts = textwrap.wrap(line, 120, break_long_words=False, break_on_hyphens=False)
    return " &\n      ".join(parts)


class MatlabPrinter(Printer):
    def _sign_of(self, x: str) -> str:
        return f"sign({x})"


def matlab_files(program: StraightLineProgram, name: str) -> dict[str, str]:
    printer = MatlabPrinter()
    outputs = ", ".join(b.name for b in program.outputs)
    inputs = ", ".join(b.name for b in program.inputs)
    lines = [f"function [{outputs}] = {name}({inputs})"]
    lines += [f"% {line}".rstrip() for line in header(program, name)]
    lines.append("% vectors are columns")
    lines += [
        f"  {symbol} = {argument}({i + 1});" for symbol, argument, i in input_elements(program)
    ]
    lines += step_lines(program, printer, "  {} = {};")
    for b in program.outputs:
        rows, columns = (*b.shape, 1)[:2]
        lines.append(f"  {b.name} = zeros({rows}, {columns});")
        elements = output_lines(b._replace(shape=(rows, columns)), printer, "  {}({}) = {};", 1)
        lines += [line for line, e in zip(elements, b.elements, strict=True) if e != 0]
    return {f"{name}.m": "\n".join([*lines, "end", ""])}


def latex_files(program: StraightLineProgram, name: str) -> dict[str, str]:
    lines = [f"  {sp.latex(s)} &= {sp.latex(e)}" for s, e in program.steps]
    for b in program.outputs:
        matrix = sp.Matrix(*(*b.shape, 1)[:2], list(b.elements))
        lines.append(f"  {sp.latex(sp.Symbol(b.name))} &= {sp.latex(matrix)}")
    comment = [f"% {line}".rstrip() for line in header(program, name)]
    equations = " \\\\\n".join(lines)
    text = "\n".join([*comment, "\\begin{align*}", equations, "\\end{align*}", ""])
    return {f"{name}.tex": text}


class PythonPrinter(Printer):
    def _sign_of(self, x: str) -> str:
        return f"(1.0 if {x} > 0 else -1.0 if {x} < 0 else {x})"


def _check(arrays: Sequence[Argument], batched: bool) -> str:
    """Statement that refuses wrong shapes, which would read past an array."""
    tests = []
    for array in arrays:
        for axis, size in enumerate(array.shape):
            tests.append(f"{array.name}.shape[{axis + batched}] != {size}")
        if batched:
            tests.append(f"{array.name}.shape[0] != {arrays[0].name}.shape[0]")
    return "    if " + " or ".join(tests) + ":\n        raise ValueError\n"


def numba_module(program: StraightLineProgram, name: str | None = None) -> str:
    """Module with `one(inputs..., outputs...)` and `many`, whose arrays have a leading axis."""
    name = name or program.name
    program, printer = distinct(program, name), PythonPrinter()
    arrays = program.arguments
    arguments = ", ".join(array.name for array in arrays)
    lines = [f"    {symbol} = {array}[{i}]" for symbol, array, i in input_elements(program)]
    lines += step_lines(program, printer, "    {} = {}")
    for b in program.outputs:
        lines += output_lines(b, printer, "    {}[{}] = {}")
    body = "\n".join(lines) + "\n"
    one = ", ".join("f8[" + ":, " * (len(b.shape) - 1) + "::1]" for b in arrays)
    many = ", ".join("f8[" + ":, " * len(b.shape) + "::1]" for b in arrays)
    rows = ", ".join(f"{b.name}[k]" for b in arrays)
    head = "\n".join(header(program, name))
    return (
        f'"""{head}\n"""\n\n'
        "from math import cos, sin, sqrt\n\n"
        "from numba import njit\n\n\n"
        f'@njit("void({one})", cache=True, error_model="numpy")\n'
        f"def {name}({arguments}):\n{_check(arrays, False)}{body}\n\n"
        f'@njit("void({many})", cache=True, error_model="numpy", nogil=True)\n'
        f"def many({arguments}):\n{_check(arrays, True)}"
        f"    for k in range({arrays[0].name}.shape[0]):\n        {name}({rows})\n\n\n"
        f"one = {name}\n"
    )


_COMPILER = "from numba import njit"
_NONE = "def njit(*_, **__):\n    return lambda function: function"


def interpreted(program: StraightLineProgram) -> Callable[..., Array]:
    """Function of the program's inputs, arrays of the stated shapes, that returns its output."""
    namespace: dict = {}
    exec(numba_module(program).replace(_COMPILER, _NONE), namespace)

    def function(*arguments) -> Array:
        arrays = [np.asarray(a, dtype=np.float64) for a in arguments]
        out = np.empty(program.outputs[0].shape)
        namespace["one"](*arrays, out)
        return out

    return function
