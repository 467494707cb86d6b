"""What a person names: a capture, a hit or a stretch of one, of a library or from a file."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lanindex.errors import AbsentError, UsageError, shown
from lanindex.formats.file import on_disk
from lanindex.library.selection import is_number
from lanindex.library.store import Store
from lanindex.model import Capture, Reading, Score, Span, Symbol
from lanindex.notation import notation_of
from lanindex.pipeline.export import from_lines, matched

_RANGE = re.compile(r"(.+):(\d+)-(\d+)", re.DOTALL)

_COUNTS = "lnd"
"""The notation that counts beats, whatever their tempo."""

_OPTIONS = {"rate": "fps"}
"""Options that are not called as what the reader is told."""


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


def counts_beats(form: str, score: Score) -> bool:
    """Return whether a score of a format counts beats that somebody told, and not seconds."""
    return form == _COUNTS or score.meter.speed != 60


def named(
    text: str,
    store: Callable[[], Store],
    reading: Reading | None = None,
    *,
    profile: str | None = None,
) -> Named:
    """Return what a person names, be it in a library or a file."""
    given = {"profile": profile, **(reading.given() if reading else {})}
    options = [f"--{_OPTIONS.get(name, name)}" for name, value in given.items() if value]
    path, span = ranged(text)
    is_file = os.path.isfile(on_disk(path))
    if options and not is_file:
        wanted = "a file: what a library holds has been read and written down"
        raise UsageError(f"{options[0]} for {shown(text)}", wanted=wanted)
    if not options:
        try:
            with store() as opened:
                return stored(opened, text)
        except AbsentError as error:
            if not is_file:
                found = f"there is no file {shown(path)}, and {error.found}"
                raise AbsentError(found, place=error.place, remedy=error.remedy) from error
    from lanindex.pipeline.convert import score_of

    score = score_of(Path(path), reading or Reading(), profile or "default")
    form = notation_of(path)
    return Named(text, path, None, score, form.name if form else "", within(span, score, text))


def stored(store: Store, text: str) -> Named:
    """Return what a person names of a library."""
    if text.lstrip().startswith("{"):
        (request,) = from_lines(store, [text])
        named = f"{request.capture.path}:{request.hit.start}-{request.hit.stop}"
        score = store.score(request.capture.id)
        return Named(
            *(named, request.capture.path, request.capture, score, request.capture.format),
            within(request.hit, score, named),
            matched(score, request),
        )
    path, span = ranged(text)
    which = int(path) if path.isdecimal() and is_number(int(path)) else path
    capture = store.capture(which)
    score = store.score(capture.id)
    return Named(text, capture.path, capture, score, capture.format, within(span, score, text))


def ranged(text: str) -> tuple[str, Span | None]:
    """Return a name without the range behind it, and the range."""
    match = _RANGE.fullmatch(text)
    return (match[1], Span(int(match[2]), int(match[3]))) if match else (text, None)


def within(span: Span | None, score: Score, named: str) -> Span:
    """Return a span that lies in a score: all of it, if none is asked for."""
    if span is None:
        return Span(0, score.frames)
    if not span.start < span.stop <= score.frames:
        found = f"frames {span.start} to {span.stop}"
        wanted = f"from less than to, and no more than its {score.frames} frames"
        raise UsageError(found, place=shown(named), wanted=wanted)
    return span
