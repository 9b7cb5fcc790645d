"""Files that appear whole or not at all: written under a hidden name, then renamed."""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def staging(path: Path) -> Path:
    """Hidden name beside `path`, to write to before it is renamed: `.NAME.*.partial`."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Hidden file that becomes `path` only when the block ends without an error."""
    partial = staging(path)
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def write_whole(file: Path, text: str) -> None:
    """Write a text file so that it is complete or as it was before."""
    with atomic(file) as partial:
        partial.write_text(text, encoding="utf-8")
