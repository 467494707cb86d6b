"""Hits to clips: which are requested, how each is cut from its source, and the manifest."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import groupby
from math import ceil
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from lanindex import formats, records
from lanindex.errors import CaptureError, ExportError, LibraryError, UsageError, quoted, shown
from lanindex.library.rows import Encoding
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Motion, Reading, Score, Span, Symbol
from lanindex.model.symbol import listed
from lanindex.notation import NOTATIONS, lnd
from lanindex.notation.excerpt import excerpt
from lanindex.pipeline import convert, manifest
from lanindex.pipeline.files import safe_stem, write_all
from lanindex.pipeline.prepare import as_ingested
from lanindex.records import of_symbol

if TYPE_CHECKING:
    from lanindex.pipeline.preview import Previews


def pad_frames(text: str, rate: Fraction, place: str = "--pad") -> int:
    """Return how many frames a time covers."""
    match = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?)(s|ms|f)|0", text.strip())
    if match is None:
        raise UsageError(
            f'"{shown(text)}"', place=place, wanted="a time such as 0.5s, 200ms or 10f"
        )
    if match[1] is None:
        return 0
    scale = {"s": rate, "ms": rate / 1000, "f": Fraction(1)}[match[2]]
    return ceil(Fraction(match[1]) * scale)


def padded(span: Span, frames: int, total: int) -> Span:
    """Return a span with `frames` more on both sides, clamped to a file of `total` frames."""
    return Span(max(0, span.start - frames), min(total, span.stop + frames))


def export(
    store: Store,
    wanted: Iterable[Request],
    folder: Path,
    *,
    pad: str = "0",
    format: str = "native",
    origin: bool = False,
    preview: str | None = None,
    force: bool = False,
) -> list[dict[str, Any]]:
    """Write clips, an LND excerpt beside each, and a manifest; all or nothing."""
    rows: list[dict[str, Any]] = []
    files = clips(store, wanted, pad=pad, format=format, origin=origin, preview=preview, rows=rows)
    write_all(
        ((folder / file.name, file.content[:]) for file in files),
        force=force,
        suspects=lambda replaced: suspects(store, replaced),
    )
    return rows


def clips(
    store: Store,
    wanted: Iterable[Request],
    *,
    pad: str = "0",
    format: str = "native",
    origin: bool = False,
    preview: str | None = None,
    rows: list[dict[str, Any]] | None = None,
) -> Iterator[formats.File]:
    """Yield clips as bytes with a name, for a folder, an archive or a network."""
    if format not in FORMATS:
        raise UsageError(f'"{shown(format)}"', place="--format", wanted=", ".join(FORMATS))
    films = _films(preview)
    rows = [] if rows is None else rows
    taken = {*manifest.NAMES}
    for _, group in groupby(wanted, key=lambda one: _identity(one.capture)):
        requests = list(group)
        held = held_as(store, requests[0].capture)
        clipper = Clipper(store, held, format, origin)
        filmed = films(store, held) if films else None
        for request in requests:
            yield from _clip(clipper, filmed, request, pad, taken, rows)
    if rows:
        yield from manifest.files(rows)


def suspects(store: Store, replaced: Iterable[Path]) -> list[str]:
    """Return the sources of the library that might be among some files.

    To look at every capture's file would take longer the more there are. A file that is a capture
    either lies where the library says, or is reached from there by links; then it has the
    capture's content. Both are looked up, and what is found is compared as a file.
    """
    places: set[str] = set()
    digests: list[str] = []
    for path in replaced:
        places |= {os.path.abspath(path), os.path.realpath(path)}
        with suppress(CaptureError):
            digests.append(formats.opened(path).sha256())
    return store.located(sorted(places), digests)


def _identity(source: Capture) -> tuple[int, str, str]:
    return source.id, source.location, source.sha256


def held_as(store: Store, source: Capture) -> Capture:
    """Return a hit's capture as the library has it; numbers alone are alike in all libraries."""
    remedy = "Search this library again."
    try:
        held = store.capture(source.id)
    except LibraryError as error:
        raise ExportError(error.found, place=source.path, remedy=remedy) from error
    if _identity(held) != _identity(source):
        found = f"is not what this library holds as number {source.id}"
        raise ExportError(found, place=source.path, remedy=remedy)
    return held


def _films(form: str | None) -> Callable[[Store, Capture], Previews] | None:
    """Return what makes films of a capture's clips, if they are asked for."""
    if form is None:
        return None
    from lanindex.film.film import FORMS
    from lanindex.pipeline.preview import Previews

    if form not in FORMS:
        raise UsageError(f'"{shown(form)}"', place="--preview", wanted=", ".join(FORMS))
    return partial(Previews, form=form)


def _clip(
    clipper: Clipper,
    filmed: Previews | None,
    request: Request,
    pad: str,
    taken: set[str],
    rows: list[dict[str, Any]],
) -> Iterator[formats.File]:
    source, hit = clipper.capture, request.hit
    if not 0 <= hit.start < hit.stop <= source.frames:
        raise ExportError(
            f"frames {hit.start} to {hit.stop}",
            place=source.path,
            wanted=f"a range inside 0 to {source.frames}, not empty",
        )
    span = padded(hit, pad_frames(pad, source.rate), source.frames)
    name = free(f"{safe_stem(source.path)}_{span.start}-{span.stop}", taken)
    for suffix, content in clipper.files(span):
        yield formats.File(name + suffix, content)
    film = None
    if filmed is not None:
        film = f"{name}.{filmed.form}"
        yield formats.File(film, filmed.film(span, request))
    rows.append(
        manifest.row(
            name + clipper.suffix,
            source,
            hit,
            span,
            fit=request.fit,
            pattern=request.pattern,
            symbols=request.symbols,
            preview=film,
        )
    )


def free(name: str, taken: set[str]) -> str:
    """Return a name that no clip has yet, also where upper and lower case are one."""
    free, number = name, 1
    while free.casefold() in taken:
        number += 1
        free = f"{name}_{number}"
    taken.add(free.casefold())
    return free


FORMATS = ("native", *convert.TARGETS, "lnd")
"""What clips can be written in."""

_Clip = Callable[[Span], Iterator[tuple[str, bytes]]]
"""Yields the files of a clip, each with its ending."""


class Clipper:
    """One source, checked against what was ingested, and its score."""

    def __init__(self, store: Store, source: Capture, form: str, origin: bool) -> None:
        self.capture = source
        self._score: Score = store.score(source.id)
        self.suffix = ".lnd"
        self._clip: _Clip = _score_alone
        notated = source.format in NOTATIONS
        if form == "lnd" or (notated and form == "native"):
            return
        if notated:
            remedy = "Use --format native, or let it be carried out: lanindex animate."
            wanted = f"a {form} source"
            raise ExportError(
                f"came as {source.format}", place=source.path, wanted=wanted, remedy=remedy
            )
        encoding = store.encoding(source.id)
        file = unchanged(source, encoding)
        reading = Reading(**encoding.options)
        own = form in ("native", source.format) and not origin
        cut = formats.cutter(file, reading) if own else None
        if cut is not None:
            named = source.path.removesuffix(f"#{file.subject}")
            self.suffix = PurePath(named).suffix.lower()
            self._clip = _cut(cut, self.suffix, formats.beside(file, reading))
            return
        target = convert.nearest(source.format) if form == "native" else form
        motion = formats.read_file(file, reading, formats.Wanted())
        self.suffix = f".{target}"
        self._clip = _anew(motion, target, origin)

    def files(self, span: Span) -> Iterator[tuple[str, bytes]]:
        """Yield the ending and the bytes of each file of a clip, the clip itself first."""
        yield from self._clip(span)
        yield ".lnd", lnd.write(excerpt(self._score, span)).encode()


def _score_alone(span: Span) -> Iterator[tuple[str, bytes]]:
    yield from ()


def _cut(cut: formats.Cutter, suffix: str, beside: tuple[tuple[str, bytes], ...]) -> _Clip:
    def clip(span: Span) -> Iterator[tuple[str, bytes]]:
        yield suffix, cut(span)
        yield from beside

    return clip


def _anew(motion: Motion, target: str, origin: bool) -> _Clip:
    def clip(span: Span) -> Iterator[tuple[str, bytes]]:
        part = convert.stretch(motion, span)
        part = convert.from_origin(part) if origin else part
        yield f".{target}", convert.written(part, target)[0]

    return clip


def unchanged(source: Capture, encoding: Encoding) -> formats.File:
    """Return a capture's file, which is as it was when it was ingested."""
    location = source.location
    try:
        file = formats.opened(location)
        unchanged = as_ingested(file, source.sha256, encoding)
    except CaptureError as error:
        raise ExportError(
            error.found,
            place=location,
            wanted="the file that was ingested",
            remedy="Ingest it again, or let go of it: lanindex remove --missing",
        ) from error
    if not unchanged:
        own = file.sha256() != source.sha256
        raise ExportError(
            f"{'has' if own else 'what it was read with has'} changed since it was ingested",
            place=location,
            wanted=f"content with sha256 {source.sha256[:12]}..." if own else "the same files",
            remedy="Ingest it again, then search again.",
        )
    return replace(file, name=location)


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


def from_range(store: Store, named: int | str, begin: int | None, end: int | None) -> Request:
    """Return what to cut for a capture and a range."""
    capture = store.capture(named)
    return Request(capture, Span(begin or 0, capture.frames if end is None else end))


def from_lines(store: Store, lines: Iterable[str | bytes]) -> list[Request]:
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
            found.append((_capture(store, hit, place), hit))
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


def _capture(store: Store, hit: dict[str, Any], place: str) -> Capture:
    """Return the capture of a hit, by its number if that still has its path."""
    try:
        by_number = store.capture(hit["capture_id"])
        if by_number.path == hit["capture"]:
            return by_number
    except (KeyError, LibraryError):
        pass
    try:
        return store.capture(hit["capture"])
    except LibraryError as error:
        raise UsageError(
            shown(error.found, 200), place=place, wanted="a capture of this library"
        ) from error
