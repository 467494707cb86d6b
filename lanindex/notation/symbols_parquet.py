"""Symbols as Parquet, by the extra ``tables``.

Source: ``NOTATIONS.md``, "Tables".
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from typing import IO, Any

from lanindex.errors import ExportError, NotationError, shown
from lanindex.model import Score
from lanindex.notation import table

GROUP = 1 << 15
"""Rows that are in memory at once."""

_TYPES = {str: "string", int: "int64", float: "float64", bool: "bool"}
_REMEDY = "It comes with: pip install 'lanindex[tables]'."


def read(content: bytes, place: str) -> Score:
    """Read the score that a table tells."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError as error:
        found = f"{error.name} is not installed"
        raise NotationError(found, place=place, remedy=_REMEDY) from error

    def rows() -> Iterator[tuple[str, Mapping[str, Any]]]:
        file = parquet.ParquetFile(pa.BufferReader(content))
        columns = [name for name in table.COLUMNS if name in file.schema_arrow.names]
        number = 0
        for batch in file.iter_batches(GROUP, columns=columns):
            for row in batch.to_pylist():
                number += 1
                where = f"{place}: row {number}"
                yield where, table.typed(row, where)

    try:
        return table.score_of(rows(), place)
    except (pa.ArrowException, OSError, ValueError, KeyError, TypeError) as error:
        found = f"damaged Parquet ({shown(str(error), 100)})"
        raise NotationError(found, place=place, wanted="a whole file") from error


def save(rows: Iterable[Mapping[str, Any]], file: IO[bytes]) -> int:
    """Write rows into a file, a group at a time; return how many there are."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError as error:
        found = f"{error.name} is not installed"
        raise ExportError(found, place="parquet", remedy=_REMEDY) from error
    kinds = {kind: pa.type_for_alias(name) for kind, name in _TYPES.items()}
    schema = pa.schema([(name, kinds[kind]) for name, kind in table.COLUMNS.items()])
    count, left = 0, iter(rows)
    with parquet.ParquetWriter(file, schema) as writer:
        while group := list(islice(left, GROUP)):
            writer.write_table(pa.Table.from_pylist(group, schema))
            count += len(group)
    return count
