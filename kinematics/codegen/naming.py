"""Names that are valid in every language, and expressions that every language can compute."""

import keyword
import re
from dataclasses import replace

import sympy as sp

from ..equations.program import Argument, StraightLineProgram
from ..expressions.exact import Expression

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}", re.ASCII)  # Fortran and MATLAB end at 63
_RESERVED = {
    *(word.lower() for word in keyword.kwlist),
    *("int", "double", "float", "const", "void", "char", "long", "short", "auto", "signed"),
    *("case", "default", "do", "enum", "extern", "goto", "inline", "register", "restrict"),
    *("sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "volatile", "asm"),
    *("end", "function", "otherwise", "parfor", "persistent", "spmd", "catch", "until", "unwind"),
    *("real", "integer", "pi", "sin", "cos", "sqrt", "sign", "merge", "zeros", "nan", "infinity"),
    *("dp", "one", "many", "njit", "range", "valueerror", "main", "errno"),
}
_COMPUTED = (
    *(sp.Add, sp.Mul, sp.Pow, sp.Number, sp.NumberSymbol),
    *(sp.cos, sp.sin, sp.sign),
)


def distinct(program: StraightLineProgram, function: str) -> StraightLineProgram:
    """The program with steps numbered without gaps, and underscores after names that collide.

    Names are distinct without regard to case, and none is that of the function.

    Raises:
        ValueError: the function or a symbol has a name that no code can have, or an expression
            holds something other than arithmetic, sine, cosine and sign.
    """
    _check_name("function", function)
    taken = {argument.name.lower() for argument in program.inputs} | _RESERVED | {function.lower()}
    outputs = [b._replace(name=_free(b.name, taken)) for b in program.outputs]
    renamed: dict[sp.Basic, sp.Basic] = {}
    parameters = [s for argument in program.inputs for s in argument.elements]
    for symbol in parameters:
        _check_name("symbol", symbol.name)
    wanted = [(s, s.name) for s in parameters]
    wanted += [(s, f"x{number}") for number, (s, _) in enumerate(program.steps)]
    _check_expressions(program, {s for s, _ in wanted})
    for symbol, wish in wanted:
        name = _free(wish, taken)
        if name != symbol.name or isinstance(symbol, sp.Dummy):
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


def _check_name(kind: str, name: str) -> None:
    if _NAME.fullmatch(name) is None or (kind == "function" and name.lower() in _RESERVED):
        allowed = "a letter, then at most 59 letters, digits and _, and no word of a language"
        raise ValueError(f"{name!r} cannot name a {kind} in code: allowed are {allowed}")


def _check_expressions(program: StraightLineProgram, known: set[Expression]) -> None:
    expressions = [e for _, e in program.steps] + [e for b in program.outputs for e in b.elements]
    for node in sp.postorder_traversal(expressions):
        if not (isinstance(node, list) or node in known or _is_computed(node)):
            allowed = "sums, products, powers, cos, sin and sign of the inputs"
            raise ValueError(f"{program.name} holds {str(node)[:60]!r}; code computes {allowed}")


def _is_computed(node: Expression) -> bool:
    return isinstance(node, _COMPUTED) and node.is_extended_real is not False
