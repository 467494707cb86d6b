"""The staves of captures, each made once and kept for the windows that are asked for next."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lanindex.draw.strip import Staff
from lanindex.library.store import Store
from lanindex.model import Hit, Score, Symbol
from lanindex.pipeline.export import held_as
from lanindex.pipeline.kept import Latest
from lanindex.pipeline.named import counts_beats

STAVES = 8
"""Staves that are kept: one of an hour takes some 100 MB, of a minute 2."""

KEPT = Latest[Staff](STAVES)
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

    def make() -> Staff:
        score = SCORES.made(own, lambda: store.score(capture.id))
        return Staff(
            score,
            parts=parts,
            detail=detail,
            marked=marked,
            seconds=not counts_beats(capture.format, score),
            scale=scale,
            stretch=stretch,
            title=capture.path,
        )

    return KEPT.made((*own, how), make).on(start or 0.0, stop)
