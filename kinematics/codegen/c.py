"""C99: a header and a source, no allocation, `const double *` in and `double *` out."""

from ..equations.program import StraightLineProgram
from .printing import Printer, header, input_elements, step_lines


def write(program: StraightLineProgram, name: str) -> dict[str, str]:
    printer = Printer()
    arguments = [f"const double *{b.name}" for b in program.inputs]
    arguments += [f"double *{b.name}" for b in program.outputs]
    signature = f"void {name}({', '.join(arguments)})"
    comment = "\n".join(f" * {line}".rstrip() for line in header(program, name))
    comment = f"/*\n{comment}\n * matrices are row by row\n */\n"
    expressions = [e for _, e in program.steps] + [e for b in program.outputs for e in b.elements]
    used = set().union(*(e.free_symbols for e in expressions))
    lines = [
        f"    const double {symbol} = {argument}[{i}];"
        for symbol, argument, i in input_elements(program)
        if symbol in used
    ]
    lines += [f"    (void){b.name};" for b in program.inputs if not used.intersection(b.elements)]
    lines += step_lines(program, printer, "    const double {} = {};")
    lines += [
        f"    {b.name}[{i}] = {printer.doprint(element)};"
        for b in program.outputs
        for i, element in enumerate(b.elements)
    ]
    guard, body = f"{name.upper()}_H", "\n".join(lines)
    declaration = (
        f"{comment}#ifndef {guard}\n#define {guard}\n\n"
        f'#ifdef __cplusplus\nextern "C" {{\n#endif\n\n{signature};\n\n'
        f"#ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )
    includes = f'#include "{name}.h"\n\n#include <math.h>\n\n'
    return {
        f"{name}.h": declaration,
        f"{name}.c": f"{comment}{includes}{signature}\n{{\n{body}\n}}\n",
    }
