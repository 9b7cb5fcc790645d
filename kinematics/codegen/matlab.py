"""MATLAB and Octave: one function file, vectors are columns, matrices are matrices."""

from ..equations.program import StraightLineProgram
from .printing import Printer, header, input_elements, step_lines, subscripts


class MatlabPrinter(Printer):
    def _sign_of(self, x: str) -> str:
        return f"sign({x})"


def write(program: StraightLineProgram, name: str) -> dict[str, str]:
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
        lines += [
            f"  {b.name}({index}) = {printer.doprint(element)};"
            for index, element in zip(subscripts((rows, columns), 1), b.elements, strict=True)
            if element != 0
        ]
    return {f"{name}.m": "\n".join([*lines, "end", ""])}
