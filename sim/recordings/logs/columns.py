"""Columns of a log: a text separated by commas, semicolons or tabulators, or a DIAdem trace.

Traces of KUKA's controllers are a header (.dat) and values beside it (.r64). Keys of the header are
numbers (ni.com, DIAdem data set header): 200 name, 202 unit, 210 IMPLIZIT or EXPLIZIT, 211 file of
the values, 213 BLOCK (values of all channels in turn), 214 REAL64, 220 number of values, 221 place
of the first value from 1, 240 start or offset, 241 step or factor.
"""

import csv
import io
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv

from armside.arrays import Array

from ...records.files import LARGEST_DATA, InputError, check_file, check_n_values
from ...records.tables import csv_form

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
    decimal: str
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
        convert = pacsv.ConvertOptions(
            include_columns=[at],
            column_types={at: kind},
            decimal_point=self.decimal,
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
    separator, decimal = csv_form(first, body)
    if separator not in first or "\0" in first:
        raise InputError(f"{file.name} is no log: it has no header line with several columns")
    cells = next(csv.reader([first.strip()], delimiter=separator))
    written = tuple(cell.strip() for cell in cells)
    named = [UNIT.fullmatch(cell) for cell in written]
    header = tuple(m[1] if m else cell for m, cell in zip(named, written, strict=True))
    units = {m[1]: m[2] for m in named if m}
    return TextTable(file, header, written, units, separator, decimal, body)


CHANNEL = re.compile(r"#BEGINCHANNELHEADER(.*?)#ENDCHANNELHEADER", re.DOTALL)
MOST_CHANNELS = 1000


@dataclass(frozen=True, eq=False)
class Diadem:
    """Channels of a trace."""

    file: Path
    header: tuple[str, ...]
    units: dict[str, str]
    values: dict[str, Array]

    @property
    def written(self) -> tuple[str, ...]:
        """Names as they are written."""
        return self.header

    def numbers(self, names: tuple[str, ...]) -> Array:
        """(N, m) of channels."""
        return np.column_stack([self.values[name] for name in names])

    def texts(self, name: str) -> list[str]:
        """Raise InputError: a channel holds numbers."""
        raise InputError(f"{self.file.name}: {name} holds numbers and no dates")


def read_diadem(file: Path) -> Diadem:
    """Channels of a header and the file that it names. Raises InputError for a damaged one."""
    text = check_file(file).read_text(encoding="latin-1")
    found = [_keys(block) for block in CHANNEL.findall(text)]
    if not 0 < len(found) <= MOST_CHANNELS:
        raise InputError(f"{file.name} is no trace: it has {len(found)} channels")
    explicit = [one for one in found if not _implicit(one)]
    n_values = int(_number(file, found[0], "220"))
    blocks = _blocks(file, explicit, n_values)
    values: dict[str, Array] = {}
    for one in found:
        if int(_number(file, one, "220")) != n_values:
            raise InputError(f"{file.name}: channels must be equally long")
        values[_text(file, one, "200")] = _values(file, one, blocks, n_values)
    if len(values) != len(found):
        raise InputError(f"{file.name} has channels of the same name")
    units = {one["200"]: one.get("202", "") for one in found}
    return Diadem(file, tuple(values), units, values)


def _keys(block: str) -> dict[str, str]:
    lines = (line.strip().partition(",") for line in block.splitlines())
    return {key: value.strip() for key, comma, value in lines if comma}


def _implicit(channel: dict[str, str]) -> bool:
    return channel.get("210", "").upper().startswith("IMPLI")


def _blocks(file: Path, channels: list[dict[str, str]], n: int) -> Array:
    """(N, channels) values of the file beside the header."""
    check_n_values(file, n * max(1, len(channels)))
    for one in channels:
        if (one.get("213"), one.get("214")) != ("BLOCK", "REAL64"):
            given = f"{one.get('213')}, {one.get('214')}"
            raise InputError(f"{file.name}: channels must be BLOCK, REAL64, got {given}")
    names = {PureWindowsPath(_text(file, one, "211")).name for one in channels}
    if len(names) != 1:
        raise InputError(f"{file.name} must name one file of values, got {sorted(names)}")
    beside = check_file(file.parent / names.pop(), LARGEST_DATA)
    if beside.stat().st_size % 8:
        raise InputError(f"{beside.name} holds no whole number of REAL64 values")
    values = np.fromfile(beside, dtype=np.float64)  # little-endian, as our machines are
    if n < 1 or len(values) != n * len(channels):
        text = f"{len(values)} values, {n} of {len(channels)} channels were announced"
        raise InputError(f"{beside.name} has {text}")
    return values.reshape(n, -1)


def _values(file: Path, channel: dict[str, str], blocks: Array, n: int) -> Array:
    start, step = (_number(file, channel, key) for key in ("240", "241"))
    if _implicit(channel):
        return start + step * np.arange(n, dtype=np.float64)
    place = int(_number(file, channel, "221")) - 1
    if not 0 <= place < blocks.shape[1]:
        raise InputError(f"{file.name}: {channel.get('200')} begins at {place + 1}")
    return start + step * blocks[:, place]


def _text(file: Path, channel: dict[str, str], key: str) -> str:
    if not channel.get(key):
        raise InputError(f"{file.name}: a channel lacks the key {key}")
    return channel[key]


def _number(file: Path, channel: dict[str, str], key: str) -> float:
    text = channel.get(key, {"240": "0", "241": "1"}.get(key, ""))
    with suppress(ValueError):
        if abs(value := float(text)) <= 1e15:
            return value
    raise InputError(f"{file.name}: key {key} must be a number, got {text[:40]!r}")
