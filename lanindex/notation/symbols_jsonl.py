"""Symbols as JSON lines, those of ``show --json``.

Source: ``NOTATIONS.md``, "Tables".
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import IO, Any

from lanindex.errors import NotationError, shown
from lanindex.model import Score
from lanindex.notation import table
from lanindex.notation.text import decoded, once


def read(content: bytes, place: str) -> Score:
    """Read the score that lines tell."""
    text = decoded(content, place, "JSON lines").removeprefix("\ufeff")
    return table.score_of(_rows(text.split("\n"), place), place)


def _rows(lines: Iterable[str], place: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for number, line in enumerate(lines, 1):
        where = f"{place}:{number}"
        if not line.strip():
            continue
        try:
            row = json.loads(line, object_pairs_hook=once)
        except (ValueError, RecursionError) as error:
            found = shown(f"damaged JSON ({error})", 200)
            raise NotationError(found, place=where, wanted="an object a line") from error
        if not isinstance(row, dict):
            raise NotationError(shown(line.strip()), place=where, wanted="an object a line")
        yield where, table.typed(row, where)


def save(rows: Iterable[Mapping[str, Any]], file: IO[bytes]) -> int:
    """Write rows into a file, one by one; return how many there are."""
    count = 0
    for row in rows:
        file.write(json.dumps(row, ensure_ascii=False).encode() + b"\n")
        count += 1
    return count
