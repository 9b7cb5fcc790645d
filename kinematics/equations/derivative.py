"""Derivatives of straight-line programs, step by step, so that nothing expands.

The chain rule is applied to each named intermediate: the derivative of a program is a program of
a few times its length, whatever the size of the expressions it stands for.
"""

from collections.abc import Mapping, Sequence

import sympy as sp

from ..expressions.symbols import Expression
from .program import Argument, StraightLineProgram, Tape


def _step_derivative(
    tape: Tape, expression: Expression, known: Mapping[Expression, Expression]
) -> Expression:
    """The directional derivative of one expression, given those of its symbols."""
    parts = [
        # The derivative of a sign is 0, its impulse at the jump left out.
        expression.diff(symbol).replace(sp.DiracDelta, lambda *_: sp.S.Zero) * known[symbol]
        for symbol in sorted(expression.free_symbols, key=str)
        if known.get(symbol, 0) != 0
    ]
    return tape(sp.Add(*parts))


def _direction(
    tape: Tape, program: StraightLineProgram, seeds: Mapping[Expression, Expression]
) -> list[tuple[Expression, ...]]:
    """Directional derivatives of each output argument, intermediates named on the tape."""
    known = dict(seeds)
    for symbol, expression in program.steps:
        known[symbol] = _step_derivative(tape, expression, known)
    return [
        tuple(_step_derivative(tape, e, known) for e in argument.elements)
        for argument in program.outputs
    ]


def tangent(program: StraightLineProgram, seeds: Mapping[str, str]) -> StraightLineProgram:
    """Jacobian-vector product: outputs differentiated along given rates of some inputs.

    seeds: input name: name of the new input with its rates. Inputs not named are constant.
    """
    tape = Tape(program)
    rates: dict[Expression, Expression] = {}
    new_inputs = []
    for argument in program.inputs:
        if argument.name in seeds:
            symbols = tuple(sp.Symbol(f"{e}_rate", real=True) for e in argument.elements)
            rates.update(zip(argument.elements, symbols, strict=True))
            new_inputs.append(Argument(seeds[argument.name], argument.shape, symbols))
    elements = _direction(tape, program, rates)
    pairs = zip(program.outputs, elements, strict=True)
    outputs = [Argument(f"{b.name}_rate", b.shape, values) for b, values in pairs]
    inputs = [*program.inputs, *new_inputs]
    return tape.program(f"{program.name}_rate", inputs, outputs, program.notes)


def jacobian_of(
    program: StraightLineProgram, with_respect_to: Sequence[str]
) -> StraightLineProgram:
    """The matrix of partial derivatives of all outputs (in a row) to all named inputs.

    Output argument `H`, shape (number of output elements, number of input elements).
    """
    tape = Tape(program)
    variables = [e for b in program.inputs if b.name in with_respect_to for e in b.elements]
    if missing := set(with_respect_to) - {b.name for b in program.inputs}:
        names = ", ".join(b.name for b in program.inputs)
        raise ValueError(f"unknown inputs {sorted(missing)}; inputs: {names}")
    derivatives = (_direction(tape, program, {variable: sp.S.One}) for variable in variables)
    columns = [[e for argument in arguments for e in argument] for arguments in derivatives]
    elements = tuple(e for row in zip(*columns, strict=True) for e in row)
    out = Argument("H", (len(columns[0]), len(columns)), elements)
    return tape.program(f"{program.name}_jacobian", program.inputs, [out], program.notes)
