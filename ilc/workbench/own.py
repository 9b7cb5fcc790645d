"""Code of a user's own, `file.py:Name`; an error in it is one line with file, line and error."""

import importlib.util
import inspect
import io
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from armside.arrays import Array

from ..laws.first_order import Law
from ..records import as_record, records
from .task import Setting
from .words import Words, guessed, unknown_name

LARGEST_FILE = 10_000_000
"""[bytes], of a user's Python file."""
ENDS = ("_exit", "execv", "execve")
"""Functions of `os` after which nothing of this process runs."""
_NUMBER = count()


class OwnCodeError(RuntimeError):
    """An error that a user's own code raised."""


@contextmanager
def in_code_of(file: Path) -> Iterator[None]:
    """Whatever the block raises in code of that file becomes OwnCodeError.

    The line named is the innermost one of the file itself; a call into a library counts there.
    Working folder, stdout, loaded modules and the end of this process are not the block's: what it
    prints goes to stderr.
    """
    try:
        with _apart():
            yield
    except (OwnCodeError, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise OwnCodeError(f"{file}{_line(error, file)}: {_said(error)}") from error


class _Stderr(io.TextIOBase):
    """Stream to stderr that may be closed without closing that."""

    def write(self, text: str, /) -> int:
        return sys.stderr.write(text)


@contextmanager
def _apart() -> Iterator[None]:
    folder, modules, loaded = os.getcwd(), sys.modules, dict(sys.modules)
    stdout, stderr, process = sys.stdout, sys.stderr, os.getpid()
    ends = {name: getattr(os, name) for name in ENDS}

    def barred(name: str, *given: Any) -> Any:
        if os.getpid() != process:  # of a worker that the code has forked
            return ends[name](*given)
        raise RuntimeError(f"os.{name} would end armside")

    stdout.flush()
    descriptor = os.dup(1)
    try:
        os.dup2(2, 1)  # of programs that the code starts
        sys.stdout = _Stderr()
        for name in ENDS:
            setattr(os, name, partial(barred, name))
        yield
    finally:
        for name, end in ends.items():
            setattr(os, name, end)
        sys.stdout, sys.stderr, sys.modules = stdout, stderr, modules
        os.dup2(descriptor, 1)
        os.close(descriptor)
        modules.update(loaded)
        os.chdir(folder)


def _line(error: BaseException, file: Path) -> str:
    whole = str(file.absolute())
    if isinstance(error, SyntaxError) and error.filename == whole:
        return f", line {error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == whole]
    return f", line {lines[-1]}" if lines else ""


def _said(error: BaseException) -> str:
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def load(file: Path, name: str) -> Any:
    """Run a Python file and return what it calls `name`; every call runs it anew."""
    if not file.is_file():
        raise ValueError(f"{file} is no Python file")
    if file.stat().st_size > LARGEST_FILE:
        raise ValueError(f"{file} is larger than {LARGEST_FILE / 1e6:.0f} MB")
    title = f"armside_own_{next(_NUMBER)}"
    spec = importlib.util.spec_from_file_location(title, file.absolute())
    if spec is None or spec.loader is None:
        raise ValueError(f"{file} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[title] = module  # a dataclass looks its module up there
    with in_code_of(file):
        spec.loader.exec_module(module)
    if not hasattr(module, name):
        public = [
            each
            for each, found in vars(module).items()
            if not each.startswith("_") and not inspect.ismodule(found)
        ]
        raise ValueError(f"{file}: {unknown_name('name', name, public)}")
    return getattr(module, name)


def built(found: Any, file: Path, offered: Mapping[str, Any], parameters: Mapping[str, Any]) -> Any:
    """The object itself, or what a class or function makes of the offered values it asks for.

    offered: values that it receives if it has parameters of these names. parameters: of the
    command line, which it must take.
    """
    if not callable(found):
        if parameters:
            raise ValueError(f"{file}: an object takes no parameters, got {', '.join(parameters)}")
        return found
    takes = _parameters(found)
    if takes is not None and (wrong := [name for name in parameters if name not in takes]):
        raise ValueError(f"{file}: {unknown_name('parameter', wrong[0], takes)}")
    given = {name: value for name, value in offered.items() if takes and name in takes}
    with in_code_of(file):
        return found(**(given | dict(parameters)))


def _parameters(function: Callable[..., Any]) -> list[str] | None:
    """Names of the parameters; None where all are taken or they cannot be known."""
    try:
        found = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return None
    if any(each.kind is inspect.Parameter.VAR_KEYWORD for each in found):
        return None
    return [each.name for each in found]


@dataclass(frozen=True, eq=False)
class OwnLaw:
    """A user's law, what it returns checked and what it raises reported with its line."""

    law: Any
    file: Path

    def check(self, n_samples: int, n_columns: int) -> None:
        if hasattr(self.law, "check"):
            with in_code_of(self.file):
                self.law.check(n_samples, n_columns)

    @records("correction", "error")
    def step(self, correction: Array, error: Array, memory: Any = None, /) -> tuple[Array, Any]:
        with in_code_of(self.file):
            if hasattr(self.law, "step"):
                found, memory = self.law.step(correction.copy(), error.copy(), memory)
            else:
                found = self.law(correction.copy(), error.copy())
            following = as_record(found, "the next correction")
            if following.shape != correction.shape:
                shapes = f"{correction.shape}, got {following.shape}"
                raise ValueError(f"the next correction must have shape {shapes}")
        return following, memory


def own_law(words: Words, setting: Setting) -> Law:
    """The law `file.py:Name:key=value`.

    Name is a law, a class whose constructor may ask for any of sample_time, reference, model,
    cutoff and experiment by name, or a function law(correction, error).

    Raises ValueError for something that is no law, OwnCodeError for what the file raises.
    """
    file = Path(words.file)
    found, parameters = load(file, words.name), guessed(words.parameters)
    if isinstance(found, type):
        names = ("sample_time", "reference", "model", "cutoff", "experiment")
        found = built(found, file, {name: getattr(setting, name) for name in names}, parameters)
    elif parameters:
        raise ValueError(f"{words.text}: only a class takes parameters")
    if not (hasattr(found, "step") or callable(found)):
        needed = "an object with step(correction, error, memory), or a function (correction, error)"
        raise ValueError(f"{words.text} is no law: give {needed}")
    return OwnLaw(found, file)
