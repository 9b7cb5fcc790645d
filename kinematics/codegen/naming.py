"""Names that every language can take: no two alike but for case, none that a language reserves."""

from dataclasses import replace

import sympy as sp

from ..equations.program import Block, Program

_RESERVED = {
    *("lambda", "in", "is", "if", "for", "while", "def", "pass", "as", "or", "and", "not", "del"),
    *("int", "double", "float", "const", "void", "return", "char", "long", "short", "auto"),
    *("end", "function", "real", "integer", "do", "pi", "sin", "cos", "sqrt", "sign", "merge"),
    *("dp", "one", "many", "njit"),
}


def distinct(program: Program) -> Program:
    """The same program with steps numbered without gaps, and a trailing underscore where names
    collide.
    """
    taken = {block.name.lower() for block in program.inputs} | _RESERVED
    outputs = []
    for block in program.outputs:
        name = _free(block.name, taken)
        taken.add(name.lower())
        outputs.append(block._replace(name=name))
    renamed: dict[sp.Basic, sp.Basic] = {}
    wanted = [(s, str(s)) for block in program.inputs for s in block.elements]
    wanted += [(s, f"x{number}") for number, (s, _) in enumerate(program.steps)]
    for symbol, wish in wanted:
        name = _free(wish, taken)
        taken.add(name.lower())
        if name != str(symbol):
            renamed[symbol] = sp.Symbol(name, real=True)

    def new(block: Block) -> Block:
        return block._replace(elements=tuple(e.xreplace(renamed) for e in block.elements))

    return replace(
        program,
        inputs=tuple(map(new, program.inputs)),
        steps=tuple((s.xreplace(renamed), e.xreplace(renamed)) for s, e in program.steps),
        outputs=tuple(map(new, outputs)),
    )


def _free(name: str, taken: set[str]) -> str:
    while name.lower() in taken:
        name += "_"
    return name
