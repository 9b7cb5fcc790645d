"""A program as a function that Python runs: for checks that are not worth a compilation."""

from collections.abc import Callable

import numpy as np

from armside.arrays import Array

from ..equations.program import StraightLineProgram
from .python import numba_module

_COMPILER = "from numba import njit"
_NONE = "def njit(*_, **__):\n    return lambda function: function"


def interpreted(program: StraightLineProgram) -> Callable[..., Array]:
    """Function of the program's inputs, arrays of the stated shapes, that returns its output."""
    namespace: dict = {}
    exec(numba_module(program).replace(_COMPILER, _NONE), namespace)

    def function(*arguments) -> Array:
        arrays = [np.asarray(a, dtype=np.float64) for a in arguments]
        out = np.empty(program.outputs[0].shape)
        namespace["one"](*arrays, out)
        return out

    return function
