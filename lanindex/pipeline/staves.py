"""The staves of captures, each made once and kept for the windows that are asked for next."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import ceil, floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.draw.plain import usual_columns
from lanindex.draw.staff import STANCES, TURN, last_second
from lanindex.draw.strip import Staff
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Score, Span, Symbol
from lanindex.model.derived import STEP, SUPPORTS
from lanindex.model.symbol import joined
from lanindex.pipeline.export import held_as
from lanindex.pipeline.kept import Latest
from lanindex.pipeline.named import counts_beats

STAVES = 8
"""Staves that are kept: one of an hour takes some 100 MB, of a minute 2."""

LONG = 300.0
"""Seconds of a capture from which on a window is drawn of its own stretch of the score alone."""

AROUND = 20.0
"""Seconds before and after a window that are read with it: what is drawn depends on them."""

SAMPLES, SAMPLE = 6, 10.0
"""Stretches of a long capture that tell which columns its staff has, and the seconds of each."""

_LOOKED_AT = (*SUPPORTS, *sorted(STANCES), STEP, TURN, "jump", "other_support")
"""Tracks that tell what is drawn of others."""

KEPT = Latest[Staff](STAVES)
COLUMNS = Latest[list[str]](256)
SCORES = Latest[Score](STAVES)


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
    encoding = store.encoding(capture.id)
    made_of = encoding.profile, encoding.digest, *sorted(encoding.options.items()), encoding.beside
    symbols = frozenset((it.part, it.start, it.stop) for it in marked)
    how = None if parts is None else (*parts,), detail, symbols, scale, stretch
    own = store.place, capture.id, capture.location, capture.sha256, made_of
    options: dict[str, Any] = {"parts": parts, "detail": detail, "scale": scale}
    options |= {"stretch": stretch, "title": capture.path}

    def make() -> Staff:
        score = SCORES.made(own, lambda: store.score(capture.id))
        beats = counts_beats(capture.format, score)
        return Staff(score, marked=marked, seconds=not beats, **options)

    whole = float(capture.frames / capture.rate)
    if not near or whole <= LONG or counts_beats(capture.format, capture):
        return KEPT.made((*own, how), make).on(start or 0.0, stop)
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
