"""What the type checker is told about SymPy, whose own annotations are partial.

An element of a SymPy matrix is annotated as an element, a list or a matrix; a derivative as an
array. We know which it is, and say so once, here, instead of at each place.
"""

from typing import Any, TypeAlias

Expression: TypeAlias = Any
"""A SymPy expression."""
SymbolicMatrix: TypeAlias = Any
"""A SymPy matrix."""
