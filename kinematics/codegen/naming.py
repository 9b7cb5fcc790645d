"""Names that are valid in every language: distinct without regard to case, none reserved."""

from dataclasses import replace

import sympy as sp

from ..equations.program import Argument, StraightLineProgram

_RESERVED = {
    *("lambda", "in", "is", "if", "for", "while", "def", "pass", "as", "or", "and", "not", "del"),
    *("int", "double", "float", "const", "void", "return", "char", "long", "short", "auto"),
    *("end", "function", "real", "integer", "do", "pi", "sin", "cos", "sqrt", "sign", "merge"),
    *("dp", "one", "many", "njit"),
}


def distinct(program: StraightLineProgram) -> StraightLineProgram:
    """The program with steps numbered without gaps, and underscores after names that collide."""
    taken = {argument.name.lower() for argument in program.inputs} | _RESERVED
    outputs = [b._replace(name=_free(b.name, taken)) for b in program.outputs]
    renamed: dict[sp.Basic, sp.Basic] = {}
    wanted = [(s, str(s)) for argument in program.inputs for s in argument.elements]
    wanted += [(s, f"x{number}") for number, (s, _) in enumerate(program.steps)]
    for symbol, wish in wanted:
        name = _free(wish, taken)
        if name != str(symbol):
            renamed[symbol] = sp.Symbol(name, real=True)

    def new(argument: Argument) -> Argument:
        return argument._replace(elements=tuple(e.xreplace(renamed) for e in argument.elements))

    return replace(
        program,
        inputs=tuple(map(new, program.inputs)),
        steps=tuple((s.xreplace(renamed), e.xreplace(renamed)) for s, e in program.steps),
        outputs=tuple(map(new, outputs)),
    )


def _free(name: str, taken: set[str]) -> str:
    """The name with underscores until it is not taken; then it is."""
    while name.lower() in taken:
        name += "_"
    taken.add(name.lower())
    return name
