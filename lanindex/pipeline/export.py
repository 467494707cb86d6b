"""Requests to clips: each cut from its source or written anew, with its score beside it."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import groupby
from math import ceil
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, NamedTuple

from lanindex import formats
from lanindex.errors import (
    CaptureError,
    ExportError,
    LanindexError,
    LibraryError,
    UsageError,
    counted,
    shown,
)
from lanindex.library.connect import no_tick
from lanindex.library.rows import Encoding
from lanindex.library.store import Store
from lanindex.model import Capture, Motion, Reading, Span
from lanindex.notation import NOTATIONS, lnd
from lanindex.notation.excerpt import excerpt
from lanindex.pipeline import convert, manifest
from lanindex.pipeline.files import safe_stem, write_all
from lanindex.pipeline.prepare import as_ingested, in_batches, size_of

if TYPE_CHECKING:
    from lanindex.library.dialect import Target
    from lanindex.pipeline.named import Request
    from lanindex.pipeline.preview import Filming
    from lanindex.pipeline.spread import Spread, Tick

FORMATS = ("native", *convert.TARGETS, "lnd")
"""What clips can be written in."""


@dataclass(frozen=True, slots=True)
class ClipOptions:
    """How clips are made; see `Library.export`."""

    pad: str = "0"
    format: str = "native"
    origin: bool = False
    preview: str | None = None


def export(
    store: Store,
    requests: Iterable[Request],
    folder: Path,
    options: ClipOptions | None = None,
    *,
    force: bool = False,
    spread: Spread | None = None,
) -> list[dict[str, Any]]:
    """Write clips, an LND excerpt beside each, and a manifest; all or nothing.

    They are made here or by other processes, which see the sources, and written here.
    """
    rows: list[dict[str, Any]] = []
    files = clips(store, requests, options or ClipOptions(), rows, store.session.note, spread)
    write_all(
        ((folder / file.name, file.content[:]) for file in files),
        force=force,
        suspects=partial(suspects, store),
    )
    return rows


def clips(
    store: Store,
    requests: Iterable[Request],
    options: ClipOptions,
    rows: list[dict[str, Any]],
    note: Callable[[str], None],
    spread: Spread | None = None,
) -> Iterator[formats.File]:
    """Yield the files of clips, then the manifest; its rows are appended to `rows`.

    `note` is given what a user should know of what is lost.
    """
    if options.format not in FORMATS:
        raise UsageError(f'"{shown(options.format)}"', place="--format", wanted=", ".join(FORMATS))
    requests, side, film = list(requests), 0.0, None
    if options.preview is not None:
        from lanindex.pipeline.preview import filmed

        side, film = filmed(store, requests, options.preview, options.pad)
    used_names, lost = {*manifest.FILES}, Counter[str]()
    made = _made(store, requests, options, film)
    if spread is not None:
        made = _made_by(spread, store, requests, options, side)
    for done, (request, clip) in enumerate(zip(requests, made, strict=True)):
        store.session.progress("clips", done, len(requests))
        name = clip_name(clip.capture, clip.span, used_names)
        for ending, content in clip.files:
            yield formats.File(name + ending, content)
        preview = None if options.preview is None else f"{name}.{options.preview}"
        rows.append(
            manifest.row(name + clip.files[0][0], clip.capture, request, clip.span, preview)
        )
        lost.update(clip.lost)
    store.session.progress("clips", len(requests), len(requests))
    if rows:
        yield from manifest.files(rows)
    if lost:
        left = ", ".join(map(counted, lost.values(), lost))
        note(f"not written to the clips: {left}")


_Files = list[tuple[str, bytes]]
"""Files of a clip by their endings, the clip itself first."""


class _Clip(NamedTuple):
    """A clip, not written yet; what none of a capture's clips has counts as lost in the first."""

    capture: Capture
    span: Span
    files: _Files
    lost: Counter[str]


def _made(
    store: Store,
    requests: Sequence[Request],
    options: ClipOptions,
    film: Filming | None,
    *,
    goes_on: bool = False,
) -> Iterator[_Clip]:
    """Yield clips with their films; the first may go on with a capture."""
    for capture, of_capture in by_capture(store, requests):
        score = store.score(capture.id)
        cut, lost = _cutter(store, capture, options)
        if goes_on:
            lost, goes_on = Counter(), False
        for request in of_capture:
            span = clip_span(capture, request.hit, options.pad)
            files, left = cut(span)
            files = [*files, (".lnd", lnd.write(excerpt(score, span)).encode())]
            if film is not None:
                files.append((f".{options.preview}", film(capture, score, request, span)))
            yield _Clip(capture, span, files, lost + left)
            lost = Counter()


_Cut = Callable[[Span], tuple[_Files, Counter[str]]]
"""Returns the files of a clip but for its score, and what is lost in it."""


def _cutter(store: Store, capture: Capture, options: ClipOptions) -> tuple[_Cut, Counter[str]]:
    """Return what cuts a capture's clips, and what of it is in none of them."""
    form, notated = options.format, capture.format in NOTATIONS
    if form == "lnd" or (notated and form == "native"):
        return lambda span: ([], Counter()), Counter()
    if notated:
        raise ExportError(
            f"came as {capture.format}",
            place=capture.path,
            wanted=f"a {form} source",
            remedy="Use --format native, or let it be carried out: lanindex animate.",
        )
    own = form in ("native", capture.format) and not options.origin
    file, reading = source_of(store, capture, sought=own and formats.is_sought(capture.format))
    cut = formats.cutter(file, reading) if own else None
    if cut is not None:
        suffix = PurePath(capture.path.removesuffix(f"#{file.subject}")).suffix.lower()
        beside = formats.beside(file, reading)

        def native(span: Span) -> tuple[_Files, Counter[str]]:
            content = cut(span)
            lost = formats.unkept(file, reading, formats.File(capture.path, content))
            return [(suffix, content), *beside], lost

        return native, Counter()
    target = convert.nearest(capture.format) if form == "native" else form
    motion = formats.read_file(file, reading, formats.Wanted())

    def written(span: Span) -> tuple[_Files, Counter[str]]:
        part = convert.stretch(motion, span)
        part = convert.from_origin(part) if options.origin else part
        return [(f".{target}", convert.file_content(part, target)[0])], Counter()

    return written, formats.unkept(file, reading, motion)


# Clips that other processes make.


class _Task(NamedTuple):
    """Clips to make, the first perhaps of the capture that another task ends with."""

    target: Target
    requests: list[Request]
    options: ClipOptions
    side: float
    goes_on: bool


def _made_by(
    spread: Spread, store: Store, requests: Sequence[Request], options: ClipOptions, side: float
) -> Iterator[_Clip]:
    """Yield clips that other processes make, in batches of about as many bytes."""

    def tasks() -> Iterator[_Task]:
        before = None
        for batch in in_batches(requests, _sizes(requests), spread.tasks):
            goes_on = before == _identity(batch[0].capture)
            yield _Task(store.session.target, batch, options, side, goes_on)
            before = _identity(batch[-1].capture)

    try:
        for made in spread.results(_make, tasks(), no_tick):
            yield from made
    except LanindexError as error:
        yield from vars(error).pop("made", ())
        raise


def _sizes(requests: Iterable[Request]) -> Iterator[int]:
    """Yield about how many bytes each clip has; with its first one a capture's file is read."""
    for _, of_capture in groupby(requests, key=lambda request: _identity(request.capture)):
        own = list(of_capture)
        size = read = size_of(own[0].capture.location)
        for request in own:
            frames = max(request.hit.stop - request.hit.start, 0)  # nobody has checked them yet
            yield read + size * frames // max(request.capture.frames, 1)
            read = 0


def _make(task: _Task, tick: Tick) -> list[_Clip]:
    """Make clips in another process; an error takes along those that were made before it.

    Where one of these cannot be written, that is told first.
    """
    from lanindex.pipeline.shards import opened

    made, film = list[_Clip](), None
    store = opened(task.target).store
    if task.options.preview is not None:
        from lanindex.pipeline.preview import filming

        film = filming(store, task.options.preview, task.side)
    try:
        for clip in _made(store, task.requests, task.options, film, goes_on=task.goes_on):
            tick()
            made.append(clip)
    except LanindexError as error:
        vars(error)["made"] = made
        raise
    return made


def clip_span(capture: Capture, hit: Span, pad: str) -> Span:
    """Return the frames of a clip: those of a hit and a time around it."""
    if not 0 <= hit.start < hit.stop <= capture.frames:
        raise ExportError(
            f"frames {hit.start} to {hit.stop}",
            place=capture.path,
            wanted=f"a range inside 0 to {capture.frames}, not empty",
        )
    return padded(hit, pad_frames(pad, capture.rate), capture.frames)


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


def clip_name(capture: Capture, span: Span, used_names: set[str]) -> str:
    """Return a name that no clip has yet, also where upper and lower case are one."""
    name = stem = f"{safe_stem(capture.path)}_{span.start}-{span.stop}"
    number = 1
    while name.casefold() in used_names:
        number += 1
        name = f"{stem}_{number}"
    used_names.add(name.casefold())
    return name


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


def _identity(capture: Capture) -> tuple[int, str, str]:
    return capture.id, capture.location, capture.sha256


def by_capture(
    store: Store, requests: Iterable[Request]
) -> Iterator[tuple[Capture, list[Request]]]:
    """Yield captures of a library, each with those requests for it that follow each other."""
    for _, group in groupby(requests, key=lambda request: _identity(request.capture)):
        own = list(group)
        yield held_as(store, own[0].capture), own


def held_as(store: Store, capture: Capture) -> Capture:
    """Return a hit's capture as the library has it; numbers alone are alike in all libraries."""
    remedy = "Search this library again."
    try:
        held = store.capture(capture.id)
    except LibraryError as error:
        raise ExportError(error.found, place=capture.path, remedy=remedy) from error
    if _identity(held) != _identity(capture):
        found = f"is not what this library holds as number {capture.id}"
        raise ExportError(found, place=capture.path, remedy=remedy)
    return held


def source_of(
    store: Store, capture: Capture, *, sought: bool = False
) -> tuple[formats.File, Reading]:
    """Return a capture's file, which is as it was when it was ingested, and how it is read.

    Of one in a store that is `sought`, only what is asked of it is fetched.
    """
    encoding = store.encoding(capture.id)
    file = check_source(capture, encoding, sought=sought)
    return replace(file, name=capture.location), Reading(**encoding.options)


def check_source(
    capture: Capture,
    encoding: Encoding,
    file: formats.File | None = None,
    *,
    sought: bool = False,
) -> formats.File:
    """Return a capture's file, which is as it was when it was ingested."""
    location = capture.location
    try:
        file = file or formats.opened(location, encoding.version if sought else "")
        unchanged = as_ingested(file, capture.sha256, encoding)
    except CaptureError as error:
        raise ExportError(
            error.found,
            place=location,
            wanted="the file that was ingested",
            remedy=error.remedy or "Ingest it again, or let go of it: lanindex remove --missing",
        ) from error
    if not unchanged:
        own = file.sha256() != capture.sha256
        raise ExportError(
            f"{'has' if own else 'what it was read with has'} changed since it was ingested",
            place=location,
            wanted=f"content with sha256 {capture.sha256[:12]}..." if own else "the same files",
            remedy="Ingest it again, then search again.",
        )
    return file


def stored_motion(store: Store, capture: Capture, rate: Fraction) -> Motion:
    """Return the motion of a capture of a library: its file read, or its score performed."""
    if capture.format in NOTATIONS:
        from lanindex.perform import perform

        return perform(store.score(capture.id), rate=rate)
    file, reading = source_of(store, capture)
    return formats.read_file(file, reading, formats.Wanted(body_only=True))
