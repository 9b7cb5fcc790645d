"""Python for numba: the module that this project itself runs."""

from ..equations.program import Block, Program
from .naming import distinct
from .printing import Printer, header, step_lines


class PythonPrinter(Printer):
    def _sign_of(self, x: str) -> str:
        return f"(1.0 if {x} > 0 else -1.0 if {x} < 0 else 0.0)"


def write(program: Program, name: str) -> dict[str, str]:
    return {f"{name}.py": numba_module(program, name)}


def _array(dimensions: int) -> str:
    return "f8[" + ":, " * (dimensions - 1) + "::1]"


def _check(blocks: tuple[Block, ...], batched: bool) -> str:
    """Shapes are checked where it costs nothing: a wrong one would read past an array."""
    tests = []
    for block in blocks:
        for axis, size in enumerate(block.shape):
            tests.append(f"{block.name}.shape[{axis + batched}] != {size}")
        if batched:
            tests.append(f"{block.name}.shape[0] != {blocks[0].name}.shape[0]")
    return "    if " + " or ".join(tests) + ":\n        raise ValueError\n"


def _stores(printer: Printer, block: Block) -> str:
    columns = block.shape[-1]
    flat = len(block.shape) == 1
    return "".join(
        f"    {block.name}[{i if flat else f'{i // columns}, {i % columns}'}] = "
        f"{printer.doprint(element)}\n"
        for i, element in enumerate(block.elements)
    )


def numba_module(program: Program, name: str | None = None) -> str:
    """Module with `one(inputs..., outputs...)` and `many`, whose arrays have a leading axis."""
    program, printer, name = distinct(program), PythonPrinter(), name or program.name
    blocks = (*program.inputs, *program.outputs)
    arguments = ", ".join(block.name for block in blocks)
    body = "".join(
        f"    {symbol} = {block.name}[{i}]\n"
        for block in program.inputs
        for i, symbol in enumerate(block.elements)
    )
    body += "".join(f"{line}\n" for line in step_lines(program, printer, "    {} = {}"))
    body += "".join(_stores(printer, block) for block in program.outputs)
    one = ", ".join(_array(len(b.shape)) for b in blocks)
    many = ", ".join(_array(len(b.shape) + 1) for b in blocks)
    rows = ", ".join(f"{b.name}[k]" for b in blocks)
    head = "\n".join(header(program, name))
    return (
        f'"""{head}\n"""\n\n'
        "from math import cos, sin, sqrt\n\n"
        "from numba import njit\n\n\n"
        f'@njit("void({one})", cache=True, error_model="numpy")\n'
        f"def {name}({arguments}):\n{_check(blocks, False)}{body}\n\n"
        f'@njit("void({many})", cache=True, error_model="numpy", nogil=True)\n'
        f"def many({arguments}):\n{_check(blocks, True)}"
        f"    for k in range({blocks[0].name}.shape[0]):\n        {name}({rows})\n\n\n"
        f"one = {name}\n"
    )
