"""Tables of signals in the files of other tools, and back: CSV, MATLAB, HDF5, MCAP.

Every form keeps the columns of `signals.parquet`, their units and the metadata; where a form knows
no missing values they are NaN. Values keep every bit.
"""

import io
import json
import re
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from itertools import count, takewhile
from math import prod
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq

from armside.arrays import Array

from .atomic import atomic
from .files import LARGEST_DATA, InputError, check_file, check_n_values, reading

Kind = TypeVar("Kind")
MARK = "# armside "
"""Start of a line of metadata in a CSV file: key, blank, JSON."""
SEPARATORS = ("\t", ";", ",")
"""Of a text's columns. The first one that its line of names has is taken."""
INTEGER, TRUTH_VALUE = "k", "tracker_valid"
"""Columns that are no floats."""
_NUMBER = re.compile(r"None|'[-+0-9.eE]+'")
TYPES = {INTEGER: pa.int32(), TRUTH_VALUE: pa.bool_()}
TRACKER = ("tracker_x", "tracker_y", "tracker_z")
STREAMS = ("tracker", "true")
"""Prefixes of columns that were sampled at a rate of their own; all others are of the log."""


def read_table(file: Path) -> pa.Table:
    """Table in a file, of the kind that its suffix names.

    Raises ValueError for an unknown suffix, InputError for a file that holds no table, is damaged
    or too large, and for HDF5 without h5py.
    """
    read = _of_kind(READERS, file)
    with reading(check_file(file, LARGEST_DATA)):
        return read(file)


def write_table(file: Path, table: pa.Table) -> None:
    """Write a table, whole or not at all, in the kind of file that the suffix names.

    Raises ValueError for an unknown suffix, InputError for HDF5 without h5py, MCAP without mcap.
    """
    write = _of_kind(WRITERS, file)
    with atomic(file) as partial:
        write(partial, table)


def _of_kind(kinds: Mapping[str, Kind], file: Path) -> Kind:
    if file.suffix.lower() not in kinds:
        raise ValueError(f"{file.name} is not of a known kind. Kinds: {', '.join(kinds)}")
    return kinds[file.suffix.lower()]


def float_columns(table: pa.Table, names: Sequence[str]) -> Array:
    """Columns (N, m) as floats, NaN for missing values. Raises KeyError for one that is missing."""
    return np.column_stack([np.empty((table.num_rows, 0)), *(floats(table, n) for n in names)])


def numbered(table: pa.Table, form: str) -> list[str]:
    """Names of a form with 1, 2, ... in place of {}, as long as there are such columns."""
    found = (form.format(i) for i in count(1))
    return list(takewhile(table.column_names.__contains__, found))


def units(table: pa.Table) -> dict[str, str]:
    """Unit of each column that has one."""
    return {
        field.name: field.metadata[b"unit"].decode()
        for field in table.schema
        if field.metadata and b"unit" in field.metadata
    }


def _metadata(table: pa.Table) -> dict[str, str]:
    own = {k.decode(): v.decode() for k, v in (table.schema.metadata or {}).items()}
    return own | {"units": json.dumps(units(table))}


def table_of(
    columns: Mapping[str, tuple[str | None, Any]], metadata: Mapping[str, str] | None = None
) -> pa.Table:
    """Table of columns by name, each a unit (or None) and an array, with metadata."""
    bare = pa.table({name: values for name, (_, values) in columns.items()})
    units = [None if unit is None else {"unit": unit} for unit, _ in columns.values()]
    fields = [field.with_metadata(unit) for field, unit in zip(bare.schema, units, strict=True)]
    schema = pa.schema(fields, metadata=dict(metadata or {}))
    return pa.Table.from_arrays(bare.columns, schema=schema)


def _table(columns: Mapping[str, pa.Array], metadata: dict[str, str]) -> pa.Table:
    unit = json.loads(metadata.pop("units", "{}"))
    return table_of({name: (unit.get(name), array) for name, array in columns.items()}, metadata)


def _read_parquet(file: Path) -> pa.Table:
    about = pq.read_metadata(file)
    check_n_values(file, about.num_rows * about.num_columns)
    return pq.read_table(file)


def _write_csv(file: Path, table: pa.Table) -> None:
    with file.open("wb") as out:
        for key, text in _metadata(table).items():
            out.write(f"{MARK}{key} {text}\n".encode())
        pacsv.write_csv(table, out, pacsv.WriteOptions(quoting_style="none"))


def csv_form(head: str, body: bytes) -> tuple[str, str]:
    """Separator and decimal point of a text with a line of names; a comma where it has neither."""
    separator = next((one for one in SEPARATORS if one in head), ",")
    comma = separator != "," and body.count(b",") > body.count(b".")
    return separator, "," if comma else "."


def _read_csv(file: Path) -> pa.Table:
    text = file.read_bytes()
    metadata: dict[str, str] = {}
    while text.startswith(b"#"):
        line, _, text = text.partition(b"\n")
        if line.startswith(MARK.encode()):
            key, _, value = line.decode()[len(MARK) :].partition(" ")
            metadata[key] = value.rstrip("\r")
    try:
        head, _, body = text.partition(b"\n")
        separator, decimal = csv_form(head.decode(), body)
        nulls: dict[str, Any] = {"null_values": [""], "strings_can_be_null": True}
        convert = pacsv.ConvertOptions(column_types=TYPES, decimal_point=decimal, **nulls)
        parse = pacsv.ParseOptions(delimiter=separator)
        table = pacsv.read_csv(io.BytesIO(text), None, parse, convert)
    except (pa.ArrowInvalid, UnicodeDecodeError) as error:
        raise ValueError(f"{file.name} is no table of numbers: {error}") from error
    return _table({name: table[name].combine_chunks() for name in table.column_names}, metadata)


def floats(table: pa.Table, name: str) -> Array:
    """(n,), a column of numbers, NaN for missing values. Raises ValueError for other columns."""
    column = table[name]
    kind = column.type
    numbers = pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_null(kind)
    if not (numbers or (pa.types.is_boolean(kind) and name == TRUTH_VALUE)):
        cells = [repr(cell) for cell in column.to_pylist()]
        row = next((i for i, cell in enumerate(cells) if not _NUMBER.fullmatch(cell)), 0)
        given = cells[row][:40] if cells else "nothing"
        raise ValueError(f"column {name}, row {row + 1}: numbers are needed, got {given} ({kind})")
    return np.array(column.cast(pa.float64()).to_numpy(zero_copy_only=False))


def _as_floats(table: pa.Table) -> dict[str, Array]:
    return {name: floats(table, name) for name in table.column_names}


def _from_floats(content: Mapping[str, Any], metadata: dict[str, str], file: Path) -> pa.Table:
    """Table of columns with NaN for missing values; a sample of a lost beam stays NaN."""
    if strange := [n for n, values in content.items() if np.iscomplexobj(values)]:
        raise ValueError(f"{file.name}: columns must be real numbers: {', '.join(strange)}")
    columns = {n: np.asarray(values, dtype=np.float64).ravel() for n, values in content.items()}
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) != 1:
        raise ValueError(f"{file.name}: columns must be equally long, got {lengths}")
    arrays: dict[str, pa.Array] = {}
    for name, values in columns.items():
        if name == INTEGER:
            whole = np.isfinite(values) & (np.rint(values) == values)
            if not (whole & (np.abs(values) <= np.iinfo(np.int32).max)).all():
                raise ValueError(f"{file.name}: column {name} must hold whole numbers")
            arrays[name] = pa.array(values.astype(np.int32))
            continue
        sampled = TRUTH_VALUE if name in TRACKER and TRUTH_VALUE in columns else name
        own = values == 1.0 if name == TRUTH_VALUE else values
        arrays[name] = pa.array(own, mask=np.isnan(columns[sampled]))
    return _table(arrays, metadata)


def _write_mat(file: Path, table: pa.Table) -> None:
    from scipy.io import savemat

    content = _as_floats(table) | {"armside_metadata": json.dumps(_metadata(table))}
    with file.open("wb") as out:
        savemat(out, content, do_compression=True, oned_as="column")


def _read_mat(file: Path) -> pa.Table:
    from scipy.io import loadmat, whosmat

    try:
        check_n_values(file, sum(prod(shape) for _, shape, _ in whosmat(file)))
        content = loadmat(file, chars_as_strings=True)
    except NotImplementedError as error:
        text = "is of MATLAB 7.3, which is HDF5; save it with -v7, or give it as .h5"
        raise ValueError(f"{file.name} {text}") from error
    metadata = json.loads(str(content.pop("armside_metadata", ["{}"])[0]))
    own = {name: values for name, values in content.items() if not name.startswith("__")}
    return _from_floats(own, metadata, file)


def _write_hdf5(file: Path, table: pa.Table) -> None:
    unit = units(table)
    content = io.BytesIO()  # HDF5 itself crashes on a full disk
    with _package("h5py").File(content, "w", track_order=True) as out:
        out.attrs.update(_metadata(table))
        for name, values in _as_floats(table).items():
            column = out.create_dataset(name, data=values, compression="gzip", shuffle=True)
            column.attrs["unit"] = unit.get(name, "")
    file.write_bytes(content.getbuffer())


def _read_hdf5(file: Path) -> pa.Table:
    with _package("h5py").File(file, "r", track_order=True) as content:
        check_n_values(file, sum(getattr(column, "size", 0) for column in content.values()))
        metadata = {key: str(text) for key, text in content.attrs.items()}
        return _from_floats(content, metadata, file)


def _write_mcap(file: Path, table: pa.Table) -> None:
    """Write a topic for log, tracker and truth each; a message a sample, as JSON; runs in turn."""
    writer_of = _package("mcap.writer")
    columns, unit = _as_floats(table), units(table)
    ks = columns.get(INTEGER, np.zeros(table.num_rows))
    stamps = _one_after_the_other(ks, columns["time"])
    topics: dict[str, list[str]] = {"log": []}
    for name in [name for name in columns if name not in (INTEGER, "time")]:
        stream = name.partition("_")[0]
        topics.setdefault(stream if stream in STREAMS else "log", []).append(name)
    with file.open("wb") as out:
        writer = writer_of.Writer(out)
        writer.start(profile="", library="armside")
        writer.add_metadata("armside", _metadata(table))
        for topic, names in topics.items():
            properties = {n: {"type": "number", "description": unit.get(n, "")} for n in names}
            schema = json.dumps({"type": "object", "properties": properties}).encode()
            schema_id = writer.register_schema(topic, "jsonschema", schema)
            channel = writer.register_channel(f"/{topic}", "json", schema_id)
            values = np.column_stack([columns[name] for name in names])
            for row in np.flatnonzero(~np.isnan(values).all(axis=1)):
                numbers = zip(names, values[row].tolist(), strict=True)
                message = {INTEGER: int(ks[row])} | {n: x for n, x in numbers if x == x}
                stamp = round(1e9 * stamps[row])
                writer.add_message(channel, stamp, json.dumps(message).encode(), stamp)
        writer.finish()


def _one_after_the_other(ks: Array, time: Array) -> Array:
    """Times [s] in which each run starts a second after the one before has ended."""
    start, out = 0.0, np.empty_like(time)
    for k in np.unique(ks):
        own = ks == k
        out[own] = start + time[own]
        start = out[own].max() + 1.0
    return out


def _package(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        needed = f"the package {name.partition('.')[0]}: pip install 'armside[convert]'"
        raise InputError(f"this kind of file needs {needed}") from error


READERS: Mapping[str, Callable[[Path], pa.Table]] = {
    ".parquet": _read_parquet,
    ".csv": _read_csv,
    ".mat": _read_mat,
    ".h5": _read_hdf5,
    ".hdf5": _read_hdf5,
}
WRITERS: Mapping[str, Callable[[Path, pa.Table], None]] = {
    ".parquet": lambda file, table: pq.write_table(table, file, compression="zstd"),
    ".csv": _write_csv,
    ".mat": _write_mat,
    ".h5": _write_hdf5,
    ".hdf5": _write_hdf5,
    ".mcap": _write_mcap,
}
