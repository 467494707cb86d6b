"""The staves of captures, each made once and kept for the windows that are asked for next."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import ceil, floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import TRACKS
from lanindex.draw.plain import usual_columns
from lanindex.draw.staff import STANCES, TURN, last_second
from lanindex.draw.strip import Staff
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Score, Span, Symbol
from lanindex.model.derived import STEP, SUPPORTS
from lanindex.model.symbol import joined
from lanindex.pipeline.export import held_as
from lanindex.pipeline.kept import CACHE, Latest, Made
from lanindex.pipeline.named import counts_beats

STAVES = 8
"""Staves that are kept: one of an hour takes some 100 MB, of a minute 2."""

LONG = 300.0
"""Seconds of a capture from which on a window is drawn of its own stretch of the score alone."""

AROUND = 20.0
"""Seconds before and after a window that are read with it: what is drawn depends on them."""

PIECE = 10.0
"""Seconds of a piece of a long staff that is drawn beforehand."""

SAMPLES, SAMPLE = 6, 10.0
"""Stretches of a long capture that tell which columns its staff has, and the seconds of each."""

_LOOKED_AT = (*SUPPORTS, *sorted(STANCES), STEP, TURN, "jump", "other_support")
"""Tracks that tell what is drawn of others."""

KEPT = Latest[Staff](STAVES)
COLUMNS = Latest[list[str]](256)
SCORES = Latest[Score](STAVES)

FAILED = set[tuple[Any, ...]]()
"""Captures whose staves could not be drawn beforehand: windows near what is damaged say why."""


def staff(
    store: Store,
    which: int | str | Hit,
    start: float | None = None,
    stop: float | None = None,
    *,
    parts: Sequence[str] | None = None,
    detail: str = "plain",
    marked: Iterable[Symbol] = (),
    scale: float = 1.0,
    stretch: float = 1.0,
    near: bool = False,
) -> Staff:
    """Return the staff of a capture: see `lanindex.Library.staff`."""
    marked = list(marked)
    if isinstance(which, Hit):
        capture, marked = held_as(store, which.capture), [*marked, *which.symbols]
        rate = float(capture.rate)
        start = which.start / rate if start is None else start
        stop = max(which.stop, which.start + 1) / rate if stop is None else stop
    else:
        capture = store.capture(which)
    symbols = frozenset((it.part, it.start, it.stop) for it in marked)
    how = None if parts is None else (*parts,), detail, symbols, scale, stretch
    own = _key(store, capture)
    options: dict[str, Any] = {"parts": parts, "detail": detail, "scale": scale}
    options |= {"stretch": stretch, "title": capture.path}

    def make() -> Staff:
        score = SCORES.made(own, lambda: store.score(capture.id))
        beats = counts_beats(capture.format, score)
        return Staff(score, marked=marked, seconds=not beats, **options)

    if not near or not _is_long(capture):
        return KEPT.made((*own, how), make).on(start or 0.0, stop)
    whole = float(capture.frames / capture.rate)
    start, stop = start or 0.0, last_second(whole, start or 0.0, stop)
    columns = None
    if parts is None and detail == "plain":
        columns = COLUMNS.made(own, lambda: _columns(store, capture))

    def make_near() -> Staff:
        frames = _frames(capture, start - AROUND, stop + AROUND)
        shown = columns if parts is None else parts
        looked_at = None if shown is None else [*dict.fromkeys((*shown, *_LOOKED_AT))]
        score, firsts = store.stretch(capture.id, frames, looked_at)
        those = [replace(it, ordinal=it.ordinal - firsts[it.part]) for it in marked]
        more: dict[str, Any] = {"columns": columns, "firsts": firsts}
        return Staff(score, marked=those, seconds=True, **options, **more)

    return KEPT.made((*own, how, start, stop), make_near).on(start, stop)


def piece(
    store: Store,
    number: int,
    start: float,
    stop: float,
    parts: list[str] | None,
    stretch: float,
    *,
    begin: bool = True,
) -> bytes | None:
    """Return a piece of a long staff as JSON (`Staff.tile`), once another process has drawn all.

    None: it has not, which may begin here; or the window is none of those of `PIECE` seconds.
    """
    capture = store.capture(number)
    ends = _ends(capture)
    at = round(start / PIECE)
    own, library = _key(store, capture), store.session.target
    drawn = _is_long(capture) and not library.in_memory and own not in FAILED
    known = parts is None or {*parts} <= {*TRACKS}
    if not (drawn and known) or at >= len(ends) or (start, stop) != (at * PIECE, ends[at]):
        return None
    options = {"parts": parts, "stretch": stretch}
    key = ("staff", *own, None if parts is None else (*parts,), stretch)
    job = {"library": str(library.name), "path": capture.path, "capture": number, **options}
    if not (CACHE.holds(key) or (begin and CACHE.idle())):
        return None
    made = CACHE.begin(key, pieces, job, aside=True)
    made.add_done_callback(lambda done: FAILED.add(own) if done.exception() else None)
    if not made.done() or made.exception():
        return None
    first, last = made.result().window("edges", at, at + 2).tolist()
    return made.result().window("pieces", first, last).tobytes()


def pieces(library: str, path: str, capture: int, parts: list[str] | None, stretch: float) -> Made:
    """Return all pieces of a long staff, in a process of its own; `path` is for errors."""
    with Store.open(library, readonly=True) as store:
        own = store.capture(capture)
        columns = _columns(store, own) if parts is None else None
        looked_at = [*dict.fromkeys((*(parts or columns or ()), *_LOOKED_AT))]
        score, _ = store.stretch(capture, Span(0, own.frames), looked_at)
        options: dict[str, Any] = {"parts": parts, "columns": columns, "stretch": stretch}
        whole = Staff(score, seconds=True, title=own.path, **options)
    starts = [0.0, *_ends(own)[:-1]]
    texts = [
        json.dumps(whole.tile(start, stop), separators=(",", ":")).encode()
        for start, stop in zip(starts, _ends(own), strict=True)
    ]
    edges = np.cumsum([0, *map(len, texts)])
    return {}, {"pieces": np.frombuffer(b"".join(texts), np.uint8), "edges": edges}


def _ends(capture: Capture) -> list[float]:
    """Return where the pieces of a staff end, seconds."""
    whole = float(capture.frames / capture.rate)
    return [*np.arange(PIECE, whole, PIECE).tolist(), whole]


def _is_long(capture: Capture) -> bool:
    """Return whether windows of a capture are drawn of their own stretch of the score."""
    seconds = float(capture.frames / capture.rate)
    return seconds > LONG and not counts_beats(capture.format, capture)


def _key(store: Store, capture: Capture) -> tuple[Any, ...]:
    """Return what tells the score of a capture from all others."""
    encoding = store.encoding(capture.id)
    made_of = encoding.profile, encoding.digest, *sorted(encoding.options.items()), encoding.beside
    return store.place, capture.id, capture.location, capture.sha256, made_of


def _columns(store: Store, capture: Capture) -> list[str]:
    """Return the columns of the staff of a long capture, as stretches of it tell."""
    counts = store.counts(capture.id)
    rows = {part: list[NDArray[Any]]() for part in counts}
    for at in np.linspace(0, float(capture.frames / capture.rate) - SAMPLE, SAMPLES):
        score, _ = store.stretch(capture.id, _frames(capture, at, at + SAMPLE))
        for part, track in score.tracks.items():
            held = rows[part]
            known = held[-1]["stop"][-1] if held and len(held[-1]) else -1
            held.append(track.symbols[track.symbols["stop"] > known])
    tracks = {part: replace(score.tracks[part], symbols=joined(it)) for part, it in rows.items()}
    return usual_columns(replace(score, tracks=tracks), [it for it in counts if counts[it]])


def _frames(capture: Capture, start: float, stop: float) -> Span:
    """Return the frames of a capture that lie in some seconds."""
    rate = float(capture.rate)
    return Span(max(floor(start * rate), 0), min(ceil(stop * rate), capture.frames))
