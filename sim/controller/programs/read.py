"""Reader of a program's file, by its ending."""

from pathlib import Path

from ...records.files import InputError, check_file
from .krl import Krl
from .program_text import ProgramText
from .rapid import Rapid
from .scanner import Text
from .urscript import UrScript

READERS = {".mod": Rapid, ".src": Krl, ".script": UrScript}
LARGEST = 4_000_000
"""[bytes]."""


def read_program_file(file: Path) -> ProgramText:
    """Program of a `.mod`, `.src` (with the `.dat` beside it) or `.script`.

    Raises ProgramError with line and column, InputError for another file.
    """
    if (ending := file.suffix.lower()) not in READERS:
        raise InputError(f"programs end with {', '.join(READERS)}: {file.name}")
    data = file.with_suffix(".DAT" if file.suffix.isupper() else ".dat")
    files = [file, data] if ending == ".src" and data.exists() else [file]
    texts = [check_file(each, LARGEST).read_bytes().decode("latin-1") for each in files]
    return read_program(*(Text(f.name, t) for f, t in zip(files, texts, strict=True)))


def read_program(*texts: Text) -> ProgramText:
    """Program of texts with such names; of KRL the data list comes last. Raises ProgramError."""
    return READERS[Path(texts[0].name).suffix.lower()](texts).read()
