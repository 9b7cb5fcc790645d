"""Columns of a log in a text: separated by commas, semicolons or tabulators."""

import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv

from armside.arrays import Array

from ...records.files import InputError

SEPARATORS = ("\t", ";", ",")
"""The first one that the header has is taken."""
UNIT = re.compile(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]")
"""Name of a column and its unit."""
COMMENTS = (b"#", b"%")


@dataclass(frozen=True, eq=False)
class TextTable:
    """A text with a header line."""

    file: Path
    header: tuple[str, ...]
    """Names without units."""
    written: tuple[str, ...]
    """Names as they are written."""
    units: dict[str, str]
    separator: str
    body: bytes

    def numbers(self, names: tuple[str, ...]) -> Array:
        """(N, m) of columns, NaN where a cell is empty. Raises InputError."""
        columns = [self._column(name, pa.float64()) for name in names]
        return np.column_stack([np.array(one.to_numpy(zero_copy_only=False)) for one in columns])

    def texts(self, name: str) -> list[str]:
        """Cells of a column."""
        return [str(cell).strip() for cell in self._column(name, pa.string()).to_pylist()]

    def _column(self, name: str, kind: pa.DataType) -> pa.ChunkedArray:
        if self.header.count(name) > 1:
            raise InputError(f"{self.file.name} has {self.header.count(name)} columns {name}")
        numbered = [f"{i}" for i in range(len(self.header))]
        at = numbered[self.header.index(name)]
        comma = self.separator != "," and self.body.count(b",") > self.body.count(b".")
        decimal = "," if comma else "."
        convert = pacsv.ConvertOptions(
            include_columns=[at],
            column_types={at: kind},
            decimal_point=decimal,
            null_values=["", " ", "nan", "NaN"],
        )
        read = pacsv.ReadOptions(column_names=numbered)
        parse = pacsv.ParseOptions(delimiter=self.separator)
        try:
            return pacsv.read_csv(io.BytesIO(self.body), read, parse, convert)[at]
        except pa.ArrowInvalid as error:
            raise InputError(f"{self.file.name}: column {name}: {error}") from error


def read_text(file: Path) -> TextTable:
    """Header and body of a text. Raises InputError for one without a header of several columns."""
    body = file.read_bytes()
    while body.startswith(COMMENTS) or body.startswith((b"\n", b"\r")):
        body = body.partition(b"\n")[2]
    line, _, body = body.partition(b"\n")
    try:
        first = line.decode("utf-8-sig")
    except UnicodeDecodeError:
        first = line.decode("latin-1")
    separator = next((one for one in SEPARATORS if one in first), None)
    if separator is None or "\0" in first:
        raise InputError(f"{file.name} is no log: it has no header line with several columns")
    cells = next(csv.reader([first.strip()], delimiter=separator))
    written = tuple(cell.strip() for cell in cells)
    named = [UNIT.fullmatch(cell) for cell in written]
    header = tuple(m[1] if m else cell for m, cell in zip(named, written, strict=True))
    units = {m[1]: m[2] for m in named if m}
    return TextTable(file, header, written, units, separator, body)
