"""Interface between learning and a plant: a correction in, the measured output back."""

from typing import Protocol, TypeVar

from armside.arrays import Array

Result_co = TypeVar("Result_co", covariant=True)


class Plant(Protocol[Result_co]):
    """One repetition of the task, always from the same initial state.

    `run` returns the measured output, shape (N, n), or a record that holds it; for a record, the
    learning loop is given a function that reads the output from it.
    """

    def run(self, correction: Array, /) -> Result_co:
        """Repeat the task with u_k = correction, shape (N, n)."""
        ...
