"""LaTeX: the intermediates one a line, then the results as matrices."""

import sympy as sp

from ..equations.program import StraightLineProgram
from .printing import header


def write(program: StraightLineProgram, name: str) -> dict[str, str]:
    lines = [f"  {sp.latex(s)} &= {sp.latex(e)}" for s, e in program.steps]
    for b in program.outputs:
        matrix = sp.Matrix(*(*b.shape, 1)[:2], list(b.elements))
        lines.append(f"  {sp.latex(sp.Symbol(b.name))} &= {sp.latex(matrix)}")
    comment = [f"% {line}".rstrip() for line in header(program, name)]
    equations = " \\\\\n".join(lines)
    text = "\n".join([*comment, "\\begin{align*}", equations, "\\end{align*}", ""])
    return {f"{name}.tex": text}
