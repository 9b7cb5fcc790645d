"""Errors that end a command, and their exit status.

The rule of the exit status: input is checked first and work is done afterwards. Anything raised
while options are parsed and configurations built, and any `InputError`, is bad input (2).
Everything else that is raised is a failure (1), also a ValueError: by then the input was accepted.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from armside.sim.records.errors import InputError as InputError


class RunFailed(RuntimeError):  # noqa: N818 - it reports an outcome of the experiment
    """The run was carried out and failed, such as a learning run that diverged."""


@contextmanager
def checking_input() -> Iterator[None]:
    """Read files and build what was asked for: errors that input can cause become InputError.

    Use it around the part of an experiment that precedes all work and all writing.
    """
    try:
        yield
    except InputError:
        raise
    except (ValueError, LookupError, OSError) as error:
        raise InputError(one_line(error)) from error


def one_line(error: BaseException) -> str:
    """The message of an error on a single line; its type where it has no message."""
    message = error.args[0] if isinstance(error, KeyError) and error.args else error
    return " ".join(str(message).split()) or type(error).__name__
