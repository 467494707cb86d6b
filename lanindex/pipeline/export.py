"""Hits to clips: exact copies of the source's frames, with their scores and a manifest."""

from __future__ import annotations

import csv
import io
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from functools import partial
from itertools import groupby
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex import formats, records
from lanindex.alphabet import KINDS, kind_of
from lanindex.errors import CaptureError, ExportError, LibraryError, UsageError, shown
from lanindex.library.store import Store
from lanindex.model import Capture, Span
from lanindex.pipeline.clipping import FORMATS, Clipper
from lanindex.pipeline.files import safe_stem, write_all
from lanindex.pipeline.requests import Request

if TYPE_CHECKING:
    from lanindex.pipeline.playing import Previews

MANIFEST = "manifest"
_FORMULAS = ("=", "+", "-", "@", "\t", "\n")


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
    library: Store,
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
    manifest: list[dict[str, Any]] = []
    how: dict[str, Any] = {"pad": pad, "format": format, "origin": origin, "preview": preview}
    files = clips(library, wanted, manifest=manifest, **how)
    write_all(
        ((folder / file.name, file.content[:]) for file in files),
        force=force,
        suspects=lambda replaced: suspects(library, replaced),
    )
    return manifest


def clips(
    library: Store,
    wanted: Iterable[Request],
    *,
    pad: str = "0",
    format: str = "native",
    origin: bool = False,
    preview: str | None = None,
    manifest: list[dict[str, Any]] | None = None,
) -> Iterator[formats.File]:
    """Yield clips as bytes with a name, for a folder, an archive or a network."""
    if format not in FORMATS:
        raise UsageError(f'"{shown(format)}"', place="--format", wanted=", ".join(FORMATS))
    films = _films(preview)
    manifest = [] if manifest is None else manifest
    taken = {f"{MANIFEST}.csv", f"{MANIFEST}.jsonl"}
    for _, group in groupby(wanted, key=lambda one: _identity(one.capture)):
        requests = list(group)
        held = held_as(library, requests[0].capture)
        clipper = Clipper(library, held, format, origin)
        filmed = films(library, held) if films else None
        for request in requests:
            yield from _clip(clipper, filmed, request, pad, taken, manifest)
    if manifest:
        lines = (json.dumps(row, ensure_ascii=False) + "\n" for row in manifest)
        yield formats.File(f"{MANIFEST}.csv", _table(manifest))
        yield formats.File(f"{MANIFEST}.jsonl", "".join(lines).encode())


def suspects(library: Store, replaced: Iterable[Path]) -> list[str]:
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
    return library.located(sorted(places), digests)


def _identity(source: Capture) -> tuple[int, str, str]:
    return source.id, source.location, source.sha256


def held_as(library: Store, source: Capture) -> Capture:
    """Return a hit's capture as the library has it; numbers alone are alike in all libraries."""
    remedy = "Search this library again."
    try:
        held = library.capture(source.id)
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
    from lanindex.pipeline.playing import Previews

    if form not in FORMS:
        raise UsageError(f'"{shown(form)}"', place="--preview", wanted=", ".join(FORMS))
    return partial(Previews, form=form)


def _clip(
    clipper: Clipper,
    filmed: Previews | None,
    request: Request,
    pad: str,
    taken: set[str],
    manifest: list[dict[str, Any]],
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
    manifest.append(
        records.of_clip(
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


def _table(manifest: list[dict[str, Any]]) -> bytes:
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, list(manifest[0]), lineterminator="\n")
    writer.writeheader()
    for row in manifest:
        writer.writerow({key: _cell(value) for key, value in row.items()})
    return text.getvalue().encode()


def _cell(value: Any) -> Any:
    """Return a value as a cell says it; no text is left that a spreadsheet would carry out."""
    if isinstance(value, list):
        value = "; ".join(map(_said, value))
    if isinstance(value, str):
        value = re.sub("\r\n?", "\n", value)  # alone it would end the row
        return f"'{value}" if value.startswith(_FORMULAS) else value
    return value


def _said(symbol: dict[str, Any]) -> str:
    words = [symbol.get(key) for key in ("part", "direction", "level")]
    if (amount := symbol.get("amount")) is not None:
        words.append(KINDS[kind_of(symbol["part"])].amount(amount))
    frames = f"{symbol['start_frame']}-{symbol['end_frame']}"
    return " ".join([*(str(word) for word in words if word), frames])
