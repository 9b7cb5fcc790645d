"""Content of a replay, without what Rerun gives anew to each file: identifiers of rows and chunks,
and how rows are shared among chunks."""

from collections import defaultdict
from pathlib import Path

import pyarrow as pa


def content(file: Path) -> dict[str, list[str]]:
    """Rows of each entity as text, sorted: times on the timelines and every component."""
    from rerun.chunk import RrdReader

    rows = defaultdict[str, list[str]](list)
    for chunk in RrdReader(file).stream().to_chunks():
        batch = chunk.to_record_batch()
        names = [name for name in batch.schema.names if "RowId" not in name]
        kept = {name: _whole(batch.column(name)) for name in names}
        rows[chunk.entity_path] += map(repr, pa.table(kept).to_pylist())
    return {entity: sorted(own) for entity, own in rows.items()}


def _whole(column: pa.Array) -> pa.Array:
    """Nanoseconds of a timeline as integers."""
    return column.cast(pa.int64()) if pa.types.is_duration(column.type) else column
