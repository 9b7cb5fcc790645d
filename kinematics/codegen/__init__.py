"""Straight-line programs as source text in five languages, and as the numba module of `compile`.

Every function says in its header comment which robot it belongs to, the convention, units, and
the order of its arguments. Matrices are row by row in C and matrices elsewhere.
"""

from collections.abc import Callable
from enum import Enum

from ..equations.program import StraightLineProgram
from .languages import c_files, fortran_files, latex_files, matlab_files
from .languages import numba_module as numba_module
from .printing import distinct


class Language(Enum):
    """Target language; the value is the word of the command line."""

    C = "c"
    MATLAB = "matlab"
    FORTRAN = "fortran"
    PYTHON = "python"
    LATEX = "latex"


_WRITERS: dict[Language, Callable[[StraightLineProgram, str], dict[str, str]]] = {
    Language.C: c_files,
    Language.MATLAB: matlab_files,
    Language.FORTRAN: fortran_files,
    Language.PYTHON: lambda program, name: {f"{name}.py": numba_module(program, name)},
    Language.LATEX: latex_files,
}


def write(
    program: StraightLineProgram, language: Language, name: str | None = None
) -> dict[str, str]:
    """Name and text of each file of a program; `name`, the program's own by default, is theirs."""
    name = name or program.name
    return _WRITERS[language](distinct(program, name), name)
