"""What to cut: from hits, from the JSON lines of a search, from a capture and a range."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lanindex import records
from lanindex.errors import LibraryError, UsageError, quoted, shown
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Score, Span, Symbol
from lanindex.model.symbol import listed
from lanindex.records import of_symbol


@dataclass(frozen=True, slots=True)
class Request:
    """A clip that is wanted."""

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
    """Return what to cut for a capture and a range."""
    capture = library.capture(named)
    return Request(capture, Span(begin or 0, capture.frames if end is None else end))


def from_lines(library: Store, lines: Iterable[str | bytes]) -> list[Request]:
    """Return what to cut for the JSON lines of a search."""
    found: list[tuple[Capture, dict[str, Any]]] = []
    pattern = ""
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        place = f"standard input:{number}"
        record = _record(line, place)
        if "capture" not in record and isinstance(record.get("summary"), dict):
            pattern = _checked(record["summary"], _SUMMARY, place).get("pattern", "")
        else:
            hit = _checked(record, _HIT, place)
            hit["symbols"] = [_checked(one, _SYMBOL, place) for one in hit.get("symbols", ())]
            found.append((_capture(library, hit, place), hit))
    return [
        Request(
            capture,
            Span(hit["start_frame"], hit["end_frame"]),
            hit.get("pattern", pattern),
            hit.get("fit"),
            tuple(hit["symbols"]),
        )
        for capture, hit in found
    ]


def matched(score: Score, request: Request) -> tuple[Symbol, ...]:
    """Return the symbols of a score that a hit names."""
    keys = ("part", "direction", "level", "start_frame", "end_frame")
    found = []
    for wanted in request.symbols:
        part = wanted["part"]
        if part in score.tracks:
            rows = score.tracks[part].symbols
            first, last = np.searchsorted(rows["start"], np.array([0, 1]) + wanted["start_frame"])
            some = (
                replace(it, ordinal=it.ordinal + int(first))
                for it in listed(part, rows[first:last])
            )
            same = {key: wanted.get(key) for key in keys}
            found += [it for it in some if {key: of_symbol(it)[key] for key in keys} == same]
    return tuple(dict.fromkeys(found))


@dataclass(frozen=True, slots=True)
class _Key:
    """What stands behind a key of a record."""

    fits: Callable[[Any], bool]
    wanted: str
    needed: bool = True


def _is_text(value: Any) -> bool:
    try:
        return isinstance(value, str) and value.encode() is not None
    except UnicodeEncodeError:  # half a pair of surrogates: JSON can say it, no file can hold it
        return False


def _is_count(value: Any) -> bool:
    return type(value) is int and 0 <= value < 1 << 63


def _is_part(value: Any) -> bool:
    return type(value) in (int, float) and 0 <= value <= 1


_TEXT = _Key(_is_text, "text")
_WORD = _Key(lambda value: value is None or _is_text(value), "a word")
_FRAME = _Key(_is_count, "a frame, counted from 0")
_SUMMARY = {"pattern": replace(_TEXT, needed=False)}
_HIT = {
    "capture": _TEXT,
    "capture_id": _Key(_is_count, "a whole number", needed=False),
    "start_frame": _FRAME,
    "end_frame": _FRAME,
    "pattern": replace(_TEXT, needed=False),
    "fit": _Key(_is_part, "a number from 0 to 1", needed=False),
    "symbols": _Key(lambda value: isinstance(value, list), "a list of symbols", needed=False),
}
_SYMBOL = {
    "part": _TEXT,
    "direction": _WORD,
    "level": _WORD,
    "start_frame": _FRAME,
    "end_frame": _FRAME,
    "amount": _Key(_is_count, "a whole number", needed=False),
}
_LINE = "a line of lanindex search --json"


def _record(line: str | bytes, place: str) -> dict[str, Any]:
    text = ""
    try:
        text = line if isinstance(line, str) else line.decode("utf-8-sig")
        record = json.loads(text)
    except (ValueError, RecursionError) as error:
        found = quoted(text.strip()) if text else "bytes that are no UTF-8"
        raise UsageError(found, place=place, wanted=_LINE) from error
    if not isinstance(record, dict):
        raise UsageError(quoted(record), place=place, wanted=_LINE)
    return record


def _checked(record: Any, keys: dict[str, _Key], place: str) -> dict[str, Any]:
    """Return the keys that are understood, each found to be what it should be."""
    if not isinstance(record, dict):
        raise UsageError(quoted(record), place=place, wanted=_LINE)
    for name, key in keys.items():
        if name not in record and key.needed:
            raise UsageError(f"no {name}", place=place, wanted=_LINE)
        if name in record and not key.fits(record[name]):
            found = f"{name} is {quoted(record[name])}"
            raise UsageError(found, place=place, wanted=f"{key.wanted}, as in {_LINE}")
    return {name: record[name] for name in keys if name in record}


def _capture(library: Store, hit: dict[str, Any], place: str) -> Capture:
    """Return the capture of a hit, by its number if that still has its path."""
    try:
        by_number = library.capture(hit["capture_id"])
        if by_number.path == hit["capture"]:
            return by_number
    except (KeyError, LibraryError):
        pass
    try:
        return library.capture(hit["capture"])
    except LibraryError as error:
        raise UsageError(
            shown(error.found, 200), place=place, wanted="a capture of this library"
        ) from error
