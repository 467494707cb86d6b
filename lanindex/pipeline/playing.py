"""What moves in a film: the motion of a capture, of a file, or of a score carried out."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from lanindex import formats
from lanindex.film.figure import figure
from lanindex.film.film import RATE, RATES, Film
from lanindex.library.store import Store
from lanindex.model import Capture, Motion, Reading, Span
from lanindex.notation import NOTATIONS
from lanindex.perform import perform
from lanindex.pipeline import convert
from lanindex.pipeline.clipping import unchanged
from lanindex.pipeline.named import Named, counts_beats
from lanindex.pipeline.requests import Request, matched


def stored_motion(library: Store, capture: Capture, rate: Fraction) -> Motion:
    """Return the motion of a capture of a library, read anew from its file."""
    if capture.format in NOTATIONS:
        return perform(library.score(capture.id), rate=rate)
    encoding = library.encoding(capture.id)
    file, told = unchanged(capture, encoding), Reading(**encoding.options)
    return formats.read_file(file, told, formats.Wanted(body_only=True))


class Previews:
    """Films of the clips of one capture."""

    def __init__(self, library: Store, capture: Capture, form: str) -> None:
        self.capture, self.form, self.rate = capture, form, RATES.get(form, RATE)
        self.score = library.score(capture.id)
        self.figure = figure(stored_motion(library, capture, self.rate))

    def film(self, span: Span, request: Request) -> bytes:
        """Return the film of a clip, what matched in colour."""
        start, stop = (float(it / self.capture.rate) for it in (span.start, span.stop))
        beats = counts_beats(self.capture.format, self.score)
        marked = matched(self.score, request)
        film = Film(
            self.figure,
            self.score,
            start=start,
            stop=stop,
            rate=self.rate,
            marked=marked,
            seconds=not beats,
        )
        return film.written(self.form)


def motion_of(found: Named, library: Callable[[], Store], told: Reading, rate: Fraction) -> Motion:
    """Return the motion of what a person names."""
    if found.format in NOTATIONS:
        return perform(found.score, rate=rate)
    if found.capture is None:
        return convert.motion_of(Path(found.path), told, body_only=True)
    with library() as opened:
        return stored_motion(opened, found.capture, rate)
