"""Films and pictures of hits: the motion of what is shown, and the files that show it."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from math import ceil
from pathlib import Path

import numpy as np

from lanindex import formats
from lanindex.body.markers import DOUBT
from lanindex.draw.svg import image
from lanindex.errors import LanindexError, UsageError, shown, writable
from lanindex.film.figure import Figure, figure
from lanindex.film.film import FORMS as FILMS
from lanindex.film.film import RATE as FILM_RATE
from lanindex.film.film import RATES, Film
from lanindex.film.hits import (
    LEAST,
    PAGE_HITS,
    RATE,
    SHEET_HITS,
    HitPreview,
    Playback,
    page,
    playback,
    preview_of,
    seen_from,
    sheet,
)
from lanindex.formats.file import Wanted
from lanindex.library.connect import Progress, no_progress
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Motion, Reading, Score, Span
from lanindex.model.capture import common_folder
from lanindex.model.derived import STEP
from lanindex.notation import NOTATIONS
from lanindex.perform import perform
from lanindex.pipeline import convert
from lanindex.pipeline.export import by_capture, clip_span, padded, source_of, stored_motion
from lanindex.pipeline.named import Named, Request, counts_beats, matched
from lanindex.search.hits import Hits

FORMS = {"png": SHEET_HITS, "svg": SHEET_HITS, "html": PAGE_HITS}
"""What hits can be shown as, and how many of them where nobody says."""

Filming = Callable[[Capture, Score, Request, Span], bytes]
"""Returns the film of a clip."""

_Body = Callable[[Capture, Span], Figure]
"""Returns who moves in a stretch of a capture, by all of its frames."""


def preview(
    store: Store, hits: Hits, path: Path, watch: Progress = no_progress
) -> Iterator[tuple[Path, bytes, list[str]]]:
    """Yield the files that show hits, and of each what cannot be seen."""
    form, folder = path.suffix.lower()[1:], common_folder(hit.path for hit in hits)
    title = f"{hits.pattern} \u00b7 {folder}" if folder.strip("./") else hits.pattern
    each, eye = len(hits) if form == "html" else SHEET_HITS, None
    for first in range(0, len(hits), each):
        some = list(hits[first : first + each])  # each is made when it is looked at
        shots: dict[int, HitPreview] = {}
        for number, shot in _shots(store, some):
            shots[number] = shot
            watch("hits", first + len(shots), len(hits))
        ordered = [shots[number] for number in range(len(some))]
        troubles = [f"{it.path} {it.when}: {it.trouble}" for it in ordered if it.trouble]
        ordered = [replace(shot, path=shot.path.removeprefix(folder)) for shot in ordered]
        eye, number = eye or seen_from(it.played for it in ordered), first // each + 1
        own = path if number == 1 else path.with_stem(f"{path.stem}-{number}")
        if form == "html":
            yield own, page(ordered, title, eye).encode(), troubles
        else:
            text = sheet(ordered, title, eye)
            yield own, text.encode() if form == "svg" else image(text), troubles


def _shots(store: Store, hits: Sequence[Hit]) -> Iterator[tuple[int, HitPreview]]:
    """Yield hits to look at by their places; a capture that is read whole is read once."""
    places = defaultdict[int, list[int]](list)
    for place, hit in enumerate(hits):
        places[hit.capture.id].append(place)
    body = _bodies(store, Fraction(RATE))
    for own in places.values():
        capture = hits[own[0]].capture
        score = _score(store, capture, [hits[place] for place in own])
        around = ceil(LEAST * capture.rate)
        for place in own:
            span = padded(Span(hits[place].start, hits[place].stop), around, capture.frames)
            try:
                found, trouble = body(capture, span), ""
            except LanindexError as error:
                found, trouble = None, f"{error.found}. {error.remedy}".removesuffix(". ")
            yield place, preview_of(score, hits[place], found, trouble)


def _score(store: Store, capture: Capture, hits: Sequence[Hit]) -> Score:
    """Return what a capture's score says of the parts that matched."""
    parts = {symbol.part for hit in hits for symbol in hit.symbols}
    if STEP in parts:  # they are drawn as what the feet do
        parts |= {"r_support", "l_support"}
    ((_, tracks),) = store.tracks([capture.id], sorted(parts))
    return Score(capture.rate, capture.frames, capture.meter, tracks)


def filmed(store: Store, requests: Iterable[Request], form: str, pad: str) -> tuple[float, Filming]:
    """Return from where films of clips are seen, all of them from one side, and what films them.

    What is alone is read once for both.
    """
    if form not in FILMS:
        raise UsageError(f'"{shown(form)}"', place="--preview", wanted=", ".join(FILMS))
    writable(form)
    body = _bodies(store, RATES.get(form, FILM_RATE))

    def played() -> Iterator[Playback | None]:
        for capture, of_capture in by_capture(store, requests):
            for it in of_capture:
                seconds = float(it.hit.start / capture.rate), float(it.hit.stop / capture.rate)
                parts = (symbol["part"] for symbol in it.symbols)
                own = body(capture, clip_span(capture, it.hit, pad))
                yield playback(own, parts, seconds, seconds)

    side = seen_from(played()).turn
    return side, filming(store, form, side, body)


def filming(store: Store, form: str, side: float, body: _Body | None = None) -> Filming:
    """Return what films clips from one side, the symbols of their hits in colour."""
    body = body or _bodies(store, RATES.get(form, FILM_RATE))

    def film(capture: Capture, score: Score, request: Request, span: Span) -> bytes:
        start, stop = (float(frame / capture.rate) for frame in (span.start, span.stop))
        return Film(
            body(capture, span),
            score,
            title=capture.path,
            start=start,
            stop=stop,
            rate=RATES.get(form, FILM_RATE),
            view=side,
            marked=matched(score, request),
            seconds=not counts_beats(capture.format, score),
        ).written(form)

    return film


def _bodies(store: Store, rate: Fraction | int) -> _Body:
    """Return what reads who moves in a stretch of a capture, a score at some frames a second.

    Of a format whose clips are sought no more is read, and little known outside the stretch. Of
    other captures the last one is kept.
    """
    whole = lru_cache(1)(lambda capture: figure(stored_motion(store, capture, Fraction(rate))))
    source = lru_cache(1)(lambda capture: source_of(store, capture, sought=True))

    @lru_cache(1)
    def body(capture: Capture, span: Span) -> Figure:
        if not formats.is_sought(capture.format):
            return whole(capture)
        file, reading = source(capture)
        reading, wanted = replace(reading, rate=capture.rate), Wanted(True, (span.start, span.stop))
        motion, frames = formats.read_file(file, reading, wanted), formats.ranged(file, reading)
        if frames is None or DOUBT in motion.warnings:  # all frames together tell joints
            return whole(capture)
        some, known = figure(motion), frames(wanted, capture.frames)
        places = np.full((capture.frames, *some.places.shape[1:]), np.nan, np.float32)
        fronts = np.zeros(capture.frames)
        places[known], fronts[known] = some.places, some.fronts
        return replace(some, places=places, fronts=fronts)

    return body


def motion_of(named: Named, store: Callable[[], Store], reading: Reading, rate: Fraction) -> Motion:
    """Return the motion of what a person names."""
    if named.format in NOTATIONS:
        return perform(named.score, rate=rate)
    if named.capture is None:
        return convert.motion_of(named.path, reading, body_only=True)
    with store() as opened:
        return stored_motion(opened, named.capture, rate)
