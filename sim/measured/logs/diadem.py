"""Traces of KUKA's controllers: a DIAdem header (.dat) and values beside it (.r64).

Keys are numbers (ni.com, DIAdem data set header): 200 name, 202 unit, 210 IMPLIZIT or EXPLIZIT,
211 file of the values, 213 BLOCK (values of all channels in turn), 214 REAL64, 220 number of
values, 221 place of the first value from 1, 240 start or offset, 241 step or factor.
"""

import re
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

import numpy as np

from armside.arrays import Array

from ...records.files import LARGEST_DATA, InputError, check_file, check_n_values

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
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{file.name}: key {key} must be a number, got {text[:40]!r}") from None
    if not np.isfinite(value) or abs(value) > 1e15:
        raise InputError(f"{file.name}: key {key} must be a number, got {text[:40]!r}")
    return value
