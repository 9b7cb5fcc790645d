"""Errors that end a command, and their exit status.

The rule of the exit status: input is checked first and work is done afterwards. Anything raised
while options are parsed, files read and configurations built, and any `InputError`, is bad input
(2). Everything else that is raised is a failure (1), also a ValueError: by then the input was
accepted.
"""

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from armside.sim.records.files import InputError as InputError

LONGEST = 500
"""Characters of a message; the middle of a longer one is left out."""


class RunFailed(RuntimeError):  # noqa: N818 - it reports an outcome of the experiment
    """The run was carried out and failed, such as a learning run that diverged."""


@contextmanager
def checking_input() -> Iterator[None]:
    """Read files and build what was asked for, before all work and all writing: every error becomes
    InputError."""
    try:
        yield
    except (InputError, RunFailed):
        raise
    except MemoryError as error:
        raise InputError("what was asked for needs more memory than there is") from error
    except Exception as error:
        raise InputError(one_line(error)) from error


def one_line(error: BaseException) -> str:
    """The message of an error on a single line of printable characters; its type where it has no
    message, and beside one that is no sentence."""
    if isinstance(error, KeyError) and error.args:
        text = printable(str(error.args[0]))
        return text if " " in text else f"the entry {text!r} is missing"
    text = printable(str(error))
    if not text:
        return type(error).__name__
    spoken = isinstance(error, (ValueError, LookupError, OSError, RuntimeError))
    ours = type(error).__module__ != "builtins"  # or a library's
    return text if spoken or ours else f"{type(error).__name__}: {text}"


def printable(text: str) -> str:
    """Text on a single line, with escapes for what a terminal would not show, and not too long."""
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in " ".join(text.split()))
    if len(line) <= LONGEST:
        return line
    return f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"


def install(extra: str) -> str:
    """The command line that installs an extra."""
    return f"pip install 'armside[{extra}]'"


@contextmanager
def needs(extra: str, user: str, package: str) -> Iterator[None]:
    """Import packages of an extra in this block; InputError where one of them is not installed.
    user: what cannot do without, such as "armside tune". package: as people write it: "Optuna"."""
    try:
        yield
    except ModuleNotFoundError as error:
        if str(error.name).split(".")[0] == "armside":
            raise
        raise InputError(f"{user} needs {package}: {install(extra)}") from error


def unknown(kind: str, given: str, names: Iterable[str]) -> InputError:
    """The error for a name that does not exist: what does, and what is near."""
    names = list(names)
    near = difflib.get_close_matches(given, names, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    return InputError(f"Unknown {kind} {given!r}.{hint} It can be: {', '.join(names)}")
