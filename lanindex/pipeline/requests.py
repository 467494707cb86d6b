"""What to cut: from hits, from the JSON lines of a search, from a capture and a range."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from lanindex import records
from lanindex.errors import LibraryError, UsageError
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Span


@dataclass(frozen=True, slots=True)
class Request:
    """A clip that is wanted.

    Attributes
    ----------
    capture : Capture
        From where.
    hit : Span
        Frames of the source.
    pattern : str
        What found it, or the empty string.
    fit : float or None
        How clearly.
    symbols : tuple of dict
        Those that matched, as in a search's JSON.
    """

    capture: Capture
    hit: Span
    pattern: str = ""
    fit: float | None = None
    symbols: tuple[dict[str, Any], ...] = ()


def from_hits(hits: Iterable[Hit], pattern: str) -> Iterator[Request]:
    """Yield what to cut for the hits of a pattern."""
    for hit in hits:
        symbols = tuple(records.of_symbol(symbol) for symbol in hit.symbols)
        yield Request(hit.capture, hit.span, pattern, round(hit.fit, 3), symbols)


def from_range(library: Store, named: int | str, begin: int | None, end: int | None) -> Request:
    """Return what to cut for a capture and a range.

    Parameters
    ----------
    library : Store
        Where the capture is.
    named : int or str
        Its number or path.
    begin, end : int or None
        Frames of the source, half-open; None: the first, or the last.
    """
    capture = library.capture(named)
    return Request(capture, Span(begin or 0, capture.frames if end is None else end))


def from_lines(library: Store, lines: Iterable[str]) -> list[Request]:
    """Return what to cut for the JSON lines of a search.

    Parameters
    ----------
    library : Store
        The one that was searched.
    lines : iterable of str
        As ``lanindex search --json`` prints them; the summary, which tells the pattern, may be
        missing.

    Returns
    -------
    list of Request

    Raises
    ------
    UsageError
        With the number of the line that is no hit.
    LibraryError
        Where a capture is not in the library.
    """
    found: list[tuple[Capture, dict[str, Any]]] = []
    pattern = ""
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        record = _record(line, f"standard input:{number}")
        if "summary" in record:
            pattern = str(record["summary"].get("pattern", ""))
        else:
            found.append((_capture(library, record, number), record))
    return [
        Request(
            capture,
            Span(record["start_frame"], record["end_frame"]),
            str(record.get("pattern", pattern)),
            record.get("fit"),
            tuple(record.get("symbols", ())),
        )
        for capture, record in found
    ]


_HIT = {"capture": str, "start_frame": int, "end_frame": int}
_SYMBOL = {"part": str, "direction": str, "level": str, "start_frame": int, "end_frame": int}


def _record(line: str, place: str) -> dict[str, Any]:
    wanted = "a line of lanindex search --json"
    try:
        record = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{line.strip()[:40]!r}", place=place, wanted=wanted) from error
    if isinstance(record, dict) and isinstance(record.get("summary"), dict):
        return record
    symbols = record.get("symbols", []) if isinstance(record, dict) else None
    _check(record, _HIT, place, wanted)
    for symbol in symbols if isinstance(symbols, list) else [None]:
        _check(symbol, _SYMBOL, place, wanted)
    return dict(record)


def _check(record: Any, keys: dict[str, type], place: str, wanted: str) -> None:
    if not isinstance(record, dict):
        raise UsageError(f"{str(record)[:40]!r}", place=place, wanted=wanted)
    for key, kind in keys.items():
        if type(record.get(key)) is not kind:
            raise UsageError(f"{key} is {record.get(key)!r}", place=place, wanted=wanted)


def _capture(library: Store, record: dict[str, Any], number: int) -> Capture:
    """Return the capture of a hit, by its number if that still has its path."""
    try:
        by_number = library.capture(record["capture_id"])
        if by_number.path == record["capture"]:
            return by_number
    except (KeyError, LibraryError):
        pass
    try:
        return library.capture(record["capture"])
    except LibraryError as error:
        raise UsageError(
            error.found, place=f"standard input:{number}", wanted="a capture of this library"
        ) from error
