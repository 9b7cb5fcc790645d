"""Python for numba: the module that `compile` runs."""

from collections.abc import Sequence

from ..equations.program import Argument, StraightLineProgram
from .naming import distinct
from .printing import Printer, header, input_elements, step_lines, subscripts


class PythonPrinter(Printer):
    def _sign_of(self, x: str) -> str:
        return f"(1.0 if {x} > 0 else -1.0 if {x} < 0 else {x})"


def write(program: StraightLineProgram, name: str) -> dict[str, str]:
    return {f"{name}.py": numba_module(program, name)}


def _array(dimensions: int) -> str:
    return "f8[" + ":, " * (dimensions - 1) + "::1]"


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
    lines += [
        f"    {b.name}[{index}] = {printer.doprint(element)}"
        for b in program.outputs
        for index, element in zip(subscripts(b.shape), b.elements, strict=True)
    ]
    body = "\n".join(lines) + "\n"
    one = ", ".join(_array(len(b.shape)) for b in arrays)
    many = ", ".join(_array(len(b.shape) + 1) for b in arrays)
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
