"""LaTeX: the intermediates one a line, then the results as matrices."""

import sympy as sp

from ..equations.program import Program
from .printing import header


def write(program: Program, name: str) -> dict[str, str]:
    lines = [f"% {line}".rstrip() for line in header(program, name)]
    lines.append("\\begin{align*}")
    lines += [f"  {sp.latex(s)} &= {sp.latex(e)} \\\\" for s, e in program.steps]
    for block in program.outputs:
        rows, columns = block.shape if len(block.shape) == 2 else (block.shape[0], 1)
        matrix = sp.Matrix(rows, columns, list(block.elements))
        lines.append(f"  {sp.latex(sp.Symbol(block.name))} &= {sp.latex(matrix)} \\\\")
    lines[-1] = lines[-1].removesuffix(" \\\\")
    return {f"{name}.tex": "\n".join([*lines, "\\end{align*}", ""])}
