"""C99: a header and a source, no allocation, `const double *` in and `double *` out."""

from ..equations.program import Program
from .printing import Printer, header, step_lines, used_symbols


def write(program: Program, name: str) -> dict[str, str]:
    printer = Printer()
    arguments = [f"const double *{block.name}" for block in program.inputs]
    arguments += [f"double *{block.name}" for block in program.outputs]
    signature = f"void {name}({', '.join(arguments)})"
    comment = "\n".join(f" * {line}".rstrip() for line in header(program, name))
    guard = f"{name.upper()}_H"
    used = used_symbols(program)
    lines = [
        f"    const double {symbol} = {block.name}[{i}];"
        for block in program.inputs
        for i, symbol in enumerate(block.elements)
        if symbol in used
    ]
    lines += [
        f"    (void){block.name};"
        for block in program.inputs
        if not used.intersection(block.elements)
    ]
    lines += step_lines(program, printer, "    const double {} = {};")
    lines += [
        f"    {block.name}[{i}] = {printer.doprint(element)};"
        for block in program.outputs
        for i, element in enumerate(block.elements)
    ]
    declaration = (
        f"/*\n{comment}\n * matrices are row by row\n */\n#ifndef {guard}\n#define {guard}\n\n"
        f'#ifdef __cplusplus\nextern "C" {{\n#endif\n\n{signature};\n\n'
        f"#ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )
    body = "\n".join(lines)
    source = (
        f'/*\n{comment}\n * matrices are row by row\n */\n#include "{name}.h"\n\n'
        f"#include <math.h>\n\n{signature}\n{{\n{body}\n}}\n"
    )
    return {f"{name}.h": declaration, f"{name}.c": source}
