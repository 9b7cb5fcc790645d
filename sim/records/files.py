"""Checks of files before they are read or written, so that a wrong one costs neither time nor
memory, and nothing is begun whose results could not be kept.
"""

import errno
import os
import secrets
import stat
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


LARGEST_TEXT = 64_000_000
"""[bytes], of a file that is parsed as a whole: a model, a drawing, a summary."""
LARGEST_DATA = 1_000_000_000
"""[bytes], of recorded data, packed or unpacked: they are worked on in memory."""
LONGEST_NAME = 255
"""[bytes], of a file's name on common file systems."""
LONGEST_PATH = 4095
"""[bytes], PATH_MAX of Linux (linux/limits.h) without its null."""
RESERVED = 24
"""[bytes], of a file's name: for the hidden one that it is written under first."""


def check_file(path: Path, largest: int = LARGEST_TEXT) -> Path:
    """The path of a regular file that can be read, of at most `largest` bytes; or InputError."""
    try:
        found = path.stat()
    except FileNotFoundError:
        raise InputError(f"{path} does not exist") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path} cannot be read: {reason}") from error
    if stat.S_ISDIR(found.st_mode):
        raise InputError(f"{path} is a folder, not a file")
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{path} is no regular file")
    if found.st_size > largest:
        size = f"{found.st_size / 1e6:.4g} MB; at most {largest / 1e6:.4g} MB are read"
        raise InputError(f"{path} has {size}")
    if not os.access(path, os.R_OK):
        raise InputError(f"{path} cannot be read: permission denied")
    return path


def check_n_values(path: Path, n: int) -> None:
    """Raise InputError for a file of n numbers, unpacked, that do not fit in memory."""
    if 8 * n > LARGEST_DATA:
        size = f"{8e-6 * n:.4g} MB; at most {LARGEST_DATA / 1e6:.4g} MB are read"
        raise InputError(f"{path.name} unpacks to {size}")


def check_file_to_write(path: Path) -> Path:
    """The path, if a regular file can be written there. Raises InputError."""
    check_name(path)
    folder = path.absolute().parent
    if not folder.is_dir():
        raise InputError(f"{path.parent} is no folder")
    if path.is_dir():
        raise InputError(f"{path} is a folder")
    if path.exists() and not path.is_file():
        raise InputError(f"{path} is no regular file")
    check_can_write(folder)
    return path


def check_can_write(folder: Path) -> None:
    """Raise InputError where nothing can be made in a folder."""
    probe = folder / f".{secrets.token_hex(4)}"
    try:  # permissions alone do not tell of a file system that is read-only
        probe.mkdir()
        probe.rmdir()
    except OSError as error:
        raise InputError(f"{folder} cannot be written to: {error.strerror}") from error


def check_name(path: Path) -> None:
    """Raise InputError for a name that is too long to be written, has a null character, is no
    text, or leads round in links."""
    if "\0" in str(path):
        raise InputError(f"{str(path)!r} has a null character")
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"{path} is no name in UTF-8") from None
    for part in path.parts:
        if (n := len(os.fsencode(part))) > LONGEST_NAME - RESERVED:
            most = LONGEST_NAME - RESERVED
            raise InputError(f"a name of {n} bytes is too long, at most {most} are: {part}")
    if (n := len(os.fsencode(path.absolute()))) > LONGEST_PATH - RESERVED:
        most = LONGEST_PATH - RESERVED
        raise InputError(f"a path of {n} bytes is too long, at most {most} are written")
    try:
        os.stat(path)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise InputError(f"{path} is a loop of links") from error
