"""The error of input that cannot be used: a file, a folder, an option."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class InputError(ValueError):
    """Bad input. The message names the given and the allowed values."""


@contextmanager
def reading(file: Path) -> Iterator[None]:
    """Read a file: whatever a damaged or foreign one raises becomes InputError, with its name."""
    try:
        yield
    except InputError:
        raise
    except KeyError as error:
        raise InputError(f"{file} lacks the entry {error}") from error
    except Exception as error:  # libraries raise many kinds for a damaged file
        raise InputError(f"{file} cannot be read: {str(error) or type(error).__name__}") from error
