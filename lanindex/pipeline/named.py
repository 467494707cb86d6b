"""What a person names: a capture, a hit or a stretch of one, of a library or from a file."""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lanindex import locations
from lanindex.errors import AbsentError, LibraryError, UsageError, quoted, shown
from lanindex.formats.file import on_disk
from lanindex.library.selection import is_number
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Reading, Score, Span, Symbol
from lanindex.model.symbol import listed
from lanindex.notation import notation_of
from lanindex.records import of_symbol

_RANGE = re.compile(r"(.+):(\d+)-(\d+)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Named:
    """A score, all of it or a stretch."""

    named: str
    path: str
    capture: Capture | None
    score: Score
    format: str
    span: Span
    matched: tuple[Symbol, ...] = ()

    @property
    def title(self) -> str:
        """Its path, and which frames of it are meant."""
        whole = len(self.span) == self.score.frames
        return self.path if whole else f"{self.path}:{self.span.start}-{self.span.stop}"

    @property
    def counted(self) -> bool:
        """Whether beats were told; else they are seconds."""
        return counts_beats(self.format, self.score)

    @property
    def seconds(self) -> tuple[float, float]:
        """From and to when it is meant."""
        rate = self.score.rate
        return float(self.span.start / rate), float(self.span.stop / rate)


def counts_beats(form: str, score: Score | Capture) -> bool:
    """Return whether a score of a format counts beats that somebody told, and not seconds."""
    return form == "lnd" or score.meter.speed != 60  # LND counts beats, whatever their tempo


def named(
    text: str,
    store: Callable[[], Store],
    reading: Reading | None = None,
    *,
    profile: str | None = None,
) -> Named:
    """Return what a person names, be it in a library or a file."""
    given = {"profile": profile, **(reading.given() if reading else {})}
    options = ["--fps" if name == "rate" else f"--{name}" for name, value in given.items() if value]
    text = locations.plain(text)
    path, _ = ranged(text)
    if options and not locations.is_file(on_disk(path)):
        wanted = "a file: what a library holds has been read and written down"
        raise UsageError(f"{options[0]} for {shown(text)}", wanted=wanted)
    if not options:
        try:
            with store() as opened:
                return stored(opened, text)
        except AbsentError as error:
            if not locations.is_file(on_disk(path)):
                found = f"there is no file {shown(path)}, and {error.found}"
                raise AbsentError(found, place=error.place, remedy=error.remedy) from error
    return from_file(text, reading or Reading(), profile or "default")


def from_file(text: str, reading: Reading, profile: str) -> Named:
    """Read the file that a person names, or a range of it."""
    from lanindex.pipeline.convert import score_of

    path, span = ranged(text)
    score, form = score_of(path, reading, profile), notation_of(path)
    return Named(text, path, None, score, form.name if form else "", within(span, score, text))


def stored(store: Store, text: str) -> Named:
    """Return what a person names of a library."""
    if text.lstrip().startswith("{"):
        (request,) = from_lines(store, [text])
        capture, hit = request.capture, request.hit
        score, text = store.score(capture.id), f"{capture.path}:{hit.start}-{hit.stop}"
        span, symbols = within(hit, score, text), matched(score, request)
    else:
        path, stretch = ranged(text)
        capture = store.capture(int(path) if path.isdecimal() and is_number(int(path)) else path)
        score = store.score(capture.id)
        span, symbols = within(stretch, score, text), ()
    return Named(text, capture.path, capture, score, capture.format, span, symbols)


def ranged(text: str) -> tuple[str, Span | None]:
    """Return a name without the range behind it, and the range."""
    match = _RANGE.fullmatch(text)
    return (match[1], Span(int(match[2]), int(match[3]))) if match else (text, None)


def within(span: Span | None, score: Score, name: str) -> Span:
    """Return a span that lies in a score: all of it, if none is asked for."""
    if span is None:
        return Span(0, score.frames)
    if not span.start < span.stop <= score.frames:
        found = f"frames {span.start} to {span.stop}"
        wanted = f"from less than to, and no more than its {score.frames} frames"
        raise UsageError(found, place=shown(name), wanted=wanted)
    return span


@dataclass(frozen=True, slots=True)
class Request:
    """A clip that is wanted."""

    capture: Capture
    hit: Span
    pattern: str = ""
    fit: float | None = None
    symbols: tuple[dict[str, Any], ...] = ()


def from_hits(hits: Iterable[Hit], pattern: str) -> Iterator[Request]:
    """Yield a request for each hit of a pattern."""
    for hit in hits:
        symbols = tuple(of_symbol(symbol) for symbol in hit.symbols)
        yield Request(hit.capture, hit.span, pattern, round(hit.fit, 3), symbols)


def from_range(store: Store, capture: int | str, begin: int | None, end: int | None) -> Request:
    """Return a request for a range of a capture; None: from its first frame, to its last."""
    held = store.capture(capture)
    return Request(held, Span(begin or 0, held.frames if end is None else end))


def from_lines(store: Store, lines: Iterable[str | bytes]) -> list[Request]:
    """Return a request for each hit in the JSON lines of a search."""
    hits: list[tuple[Capture, dict[str, Any]]] = []
    pattern = ""
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        place = f"standard input:{number}"
        record = _record(line, place)
        if "capture" not in record and isinstance(record.get("summary"), dict):
            pattern = _checked_keys(record["summary"], _SUMMARY, place).get("pattern", "")
        else:
            hit = _checked_keys(record, _HIT, place)
            hit["symbols"] = [_checked_keys(one, _SYMBOL, place) for one in hit.get("symbols", ())]
            hits.append((_capture(store, hit, place), hit))
    return [
        Request(
            capture,
            Span(hit["start_frame"], hit["end_frame"]),
            hit.get("pattern", pattern),
            hit.get("fit"),
            tuple(hit["symbols"]),
        )
        for capture, hit in hits
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
            same = {key: wanted.get(key) for key in keys}
            found += [
                replace(symbol, ordinal=symbol.ordinal + int(first))
                for symbol in listed(part, rows[first:last])
                if {key: of_symbol(symbol)[key] for key in keys} == same
            ]
    return tuple(dict.fromkeys(found))


def _is_text(value: Any) -> bool:
    # without half a pair of surrogates, which JSON can say and no file can hold
    return isinstance(value, str) and not re.search("[\ud800-\udfff]", value)


def _is_count(value: Any) -> bool:
    return type(value) is int and 0 <= value < 1 << 63


_FITS: dict[str, Callable[[Any], bool]] = {
    "text": _is_text,
    "a word": lambda value: value is None or _is_text(value),
    "a frame, counted from 0": _is_count,
    "a whole number": _is_count,
    "a number from 0 to 1": lambda value: type(value) in (int, float) and 0 <= value <= 1,
    "a list of symbols": lambda value: isinstance(value, list),
}
"""Whether a value is what a key of a record wants, by how messages call that."""

_SUMMARY = {"pattern?": "text"}
_HIT = {
    "capture": "text",
    "capture_id?": "a whole number",
    "start_frame": "a frame, counted from 0",
    "end_frame": "a frame, counted from 0",
    "pattern?": "text",
    "fit?": "a number from 0 to 1",
    "symbols?": "a list of symbols",
}
_SYMBOL = {
    "part": "text",
    "direction": "a word",
    "level": "a word",
    "start_frame": "a frame, counted from 0",
    "end_frame": "a frame, counted from 0",
    "amount?": "a whole number",
}
"""The keys of records and what each wants; those with a question mark may be absent."""

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


def _checked_keys(record: Any, keys: dict[str, str], place: str) -> dict[str, Any]:
    """Return the keys that are understood, each found to be what it should be."""
    if not isinstance(record, dict):
        raise UsageError(quoted(record), place=place, wanted=_LINE)
    checked = {}
    for key, wanted in keys.items():
        name = key.removesuffix("?")
        if name in record:
            checked[name] = record[name]
            if not _FITS[wanted](record[name]):
                found = f"{name} is {quoted(record[name])}"
                raise UsageError(found, place=place, wanted=f"{wanted}, as in {_LINE}")
        elif name == key:
            raise UsageError(f"no {name}", place=place, wanted=_LINE)
    return checked


def _capture(store: Store, hit: dict[str, Any], place: str) -> Capture:
    """Return the capture of a hit, by its number if that still has its path."""
    with suppress(KeyError, LibraryError):
        by_number = store.capture(hit["capture_id"])
        if by_number.path == hit["capture"]:
            return by_number
    try:
        return store.capture(hit["capture"])
    except LibraryError as error:
        found, wanted = shown(error.found, 200), "a capture of this library"
        raise UsageError(found, place=place, wanted=wanted) from error
