"""MATLAB and Octave: one function file, vectors are columns, matrices are matrices."""

from ..equations.program import Program
from .printing import Printer, header, step_lines


class MatlabPrinter(Printer):
    def _sign_of(self, x: str) -> str:
        return f"sign({x})"


def write(program: Program, name: str) -> dict[str, str]:
    printer = MatlabPrinter()
    outputs = ", ".join(block.name for block in program.outputs)
    inputs = ", ".join(block.name for block in program.inputs)
    lines = [f"function [{outputs}] = {name}({inputs})"]
    lines += [f"% {line}".rstrip() for line in header(program, name)]
    lines.append("% vectors are columns")
    lines += [
        f"  {symbol} = {block.name}({i + 1});"
        for block in program.inputs
        for i, symbol in enumerate(block.elements)
    ]
    lines += step_lines(program, printer, "  {} = {};")
    for block in program.outputs:
        rows, columns = block.shape if len(block.shape) == 2 else (block.shape[0], 1)
        lines.append(f"  {block.name} = zeros({rows}, {columns});")
        lines += [
            f"  {block.name}({i // columns + 1}, {i % columns + 1}) = {printer.doprint(element)};"
            for i, element in enumerate(block.elements)
            if element != 0
        ]
    return {f"{name}.m": "\n".join([*lines, "end", ""])}
