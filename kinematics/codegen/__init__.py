"""Straight-line programs as source text in five languages, and as the numba module of `compile`.

Every function says in its header comment which robot it belongs to, the convention, units, and
the order of its arguments. Matrices are row by row in C and matrices elsewhere.
"""

from collections.abc import Callable
from enum import Enum

from ..equations.program import StraightLineProgram
from . import c, fortran, latex, matlab, python
from .naming import distinct
from .python import numba_module as numba_module


class Language(Enum):
    """Target language; the value is the word of the command line."""

    C = "c"
    MATLAB = "matlab"
    FORTRAN = "fortran"
    PYTHON = "python"
    LATEX = "latex"


_WRITERS: dict[Language, Callable[[StraightLineProgram, str], dict[str, str]]] = dict(
    zip(Language, (c.write, matlab.write, fortran.write, python.write, latex.write), strict=True)
)


def write(
    program: StraightLineProgram, language: Language, name: str | None = None
) -> dict[str, str]:
    """Name and text of each file of a program; `name`, the program's own by default, is theirs."""
    name = name or program.name
    return _WRITERS[language](distinct(program, name), name)
