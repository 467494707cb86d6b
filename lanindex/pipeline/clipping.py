"""Clips out of one source: its bytes where they can be cut, else its motion written anew."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import PurePath

from lanindex import formats
from lanindex.errors import CaptureError, ExportError
from lanindex.library.encoding import Encoding
from lanindex.library.store import Store
from lanindex.model import Capture, Motion, Reading, Score, Span
from lanindex.notation import NOTATIONS, lnd
from lanindex.notation.excerpt import excerpt
from lanindex.pipeline import convert
from lanindex.pipeline.prepare import as_ingested

FORMATS = ("native", *convert.TARGETS, "lnd")
"""What clips can be written in."""

_Clip = Callable[[Span], Iterator[tuple[str, bytes]]]
"""Yields the files of a clip, each with its ending."""


class Clipper:
    """One source, checked against what was ingested, and its score."""

    def __init__(self, library: Store, source: Capture, form: str, origin: bool) -> None:
        self.capture = source
        self._score: Score = library.score(source.id)
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
        encoding = library.encoding(source.id)
        file = unchanged(source, encoding)
        told = Reading(**encoding.options)
        own = form in ("native", source.format) and not origin
        cut = formats.cutter(file, told) if own else None
        if cut is not None:
            named = source.path.removesuffix(f"#{file.subject}")
            self.suffix = PurePath(named).suffix.lower()
            self._clip = _cut(cut, self.suffix, formats.beside(file, told))
            return
        target = convert.nearest(source.format) if form == "native" else form
        motion = formats.read_file(file, told, formats.Wanted())
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
