"""Symbols as comma-separated values, with a line of names.

Source: ``NOTATIONS.md``, "Tables".
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from io import StringIO, TextIOWrapper
from typing import IO, Any

from lanindex.errors import NotationError, shown
from lanindex.model import Score
from lanindex.notation import table
from lanindex.notation.text import decoded


def read(content: bytes, place: str) -> Score:
    """Read the score that a table tells."""
    text = decoded(content, place, "a table of symbols").removeprefix("\ufeff")
    return table.score_of(_rows(csv.reader(StringIO(text, newline="")), place), place)


def _rows(lines: Any, place: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    try:
        names: list[str] = next(lines, [])
        if absent := [name for name in ("part", "start_frame") if name not in names]:
            wanted = f"a line of names, as {', '.join(table.COLUMNS)}"
            raise NotationError(f"no column {absent[0]}", place=place, wanted=wanted)
        if again := [name for at, name in enumerate(names) if name in names[:at]]:
            found = f"the column {shown(again[0])} twice"
            raise NotationError(found, place=place, wanted="each once")
        for values in filter(None, lines):
            where = f"{place}:{lines.line_num}"
            if len(values) != len(names):
                found = f"{len(values)} values"
                raise NotationError(
                    found, place=where, wanted=f"{len(names)}, as in the first line"
                )
            yield where, table.typed(dict(zip(names, values, strict=True)), where)
    except csv.Error as error:
        raise NotationError(str(error), place=f"{place}:{lines.line_num}") from error


def save(rows: Iterable[Mapping[str, Any]], file: IO[bytes]) -> int:
    """Write rows into a file, one by one; return how many there are."""
    count = 0
    text = TextIOWrapper(file, "utf-8", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.COLUMNS)
    for row in rows:
        writer.writerow([str(it).lower() if isinstance(it, bool) else it for it in row.values()])
        count += 1
    text.detach()
    return count
