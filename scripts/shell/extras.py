"""Extras of the distribution: packages that serve one command, and the line that names them."""

from collections.abc import Iterator
from contextlib import contextmanager

from .errors import InputError


def install(extra: str) -> str:
    """The command line that installs an extra."""
    return f"pip install 'armside[{extra}]'"


@contextmanager
def needs(extra: str, user: str, package: str) -> Iterator[None]:
    """Import packages of an extra in this block; InputError where one of them is not installed.

    user: what cannot do without, such as "armside tune". package: as people write it: "Optuna".
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if str(error.name).split(".")[0] == "armside":
            raise
        raise InputError(f"{user} needs {package}: {install(extra)}") from error
