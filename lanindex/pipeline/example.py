"""Search by example: a capture, a file, a hit or a stretch of one is the question."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from lanindex.alphabet import kind_of
from lanindex.errors import AbsentError, CaptureError, NotationError, UsageError, shown
from lanindex.library.find import is_number
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Span, Track
from lanindex.model.columns import Roster, columns_of
from lanindex.pipeline.named import ranged, stored, within
from lanindex.pipeline.patience import Patience, silent
from lanindex.search.example.align import Clips, Pair, Source, pairs
from lanindex.search.example.nearest import Near, nearest
from lanindex.search.hits import Hits

BEST = 100
"""How many captures are told where no limit is set."""


@dataclass(frozen=True, slots=True)
class Example:
    """A clip that others shall be like."""

    named: str
    capture: Capture | None
    path: str
    tracks: Mapping[str, Track]
    rate: float
    span: Span

    def clip(self) -> Clips:
        """Return it laid out, the limbs in which it moves or stands."""
        nobody = Capture(0, "", "", "", "", Fraction(self.rate), self.span.stop)
        limbs = {
            part: columns_of(part, [nobody], [track])
            for part, track in self.tracks.items()
            if kind_of(part) == "gesture" and len(track)
        }
        only = np.zeros(1, np.int64)
        source = Source(limbs, only, only + self.span.stop, np.array([self.rate]))
        clip = source.taken(only).cut(0, self.span.start, self.span.stop) if limbs else None
        if clip is None or not clip.moves.sizes.any():
            place = f"--like {shown(self.named)}"
            raise UsageError("nothing moves there", place=place, wanted="one movement at least")
        return clip


def example(library: Store, named: int | str | os.PathLike[str]) -> Example:
    """Return the clip that a person names."""
    text = str(named) if isinstance(named, int) else os.fspath(named)
    try:
        one = stored(library, text)
    except AbsentError as error:
        path, span = ranged(text)
        if not os.path.isfile(path):
            if is_number(named):
                raise
            found = f"there is no capture and no file {shown(path)}"
            raise UsageError(found, place="--like", remedy=error.remedy) from error
        return _read(library, path, text, span)
    path = one.capture.location if one.capture else one.path
    tracks, rate = one.score.tracks, float(one.score.rate)
    return Example(one.named, one.capture, path, tracks, rate, one.span)


def _read(library: Store, path: str, named: str, span: Span | None) -> Example:
    """Return a file's clip, written down as most captures of the library are."""
    from lanindex.encoding.profile import load
    from lanindex.pipeline.prepare import Task, prepare_one

    profiles = {name: count for name, count in library.stats().profiles.items() if name}
    name = max(profiles, key=profiles.__getitem__, default="default")
    try:
        profile = load(name)
    except NotationError as error:
        raise UsageError(
            f'the library is written down by the profile "{name}", which is not built in',
            place=f"--like {shown(named)}",
            remedy="Ingest the file with that profile, and name it as a capture of the library.",
        ) from error
    outcome = prepare_one(Task(path, profile))
    if outcome.score is None:
        raise CaptureError(outcome.error or "cannot be read")
    score = outcome.score
    whole = within(span, score, named)
    return Example(named, None, path, score.tracks, float(score.rate), whole)


@dataclass(frozen=True, slots=True)
class Alike:
    """What is like an example."""

    example: Example
    hits: Hits
    captures: int
    aligned: int
    sure: bool
    told: tuple[str, ...] = ()


def alike(
    library: Store,
    one: Example,
    chosen: Iterable[int] | None,
    limit: int = BEST,
    patience: Patience | None = None,
) -> Alike:
    """Return the captures of a library that are most like a clip; its own is left out."""
    query, watch = one.clip(), patience or Patience(silent, None)
    roster, source = source_of(library, chosen, query.parts, one.capture)
    found = nearest(query, len(one.span) / one.rate, source, limit, watch=watch)
    hits = Hits(_hits(library, query, roster, source, found.near), f"like {one.named}")
    return Alike(one, hits, len(roster), found.aligned, found.sure)


def source_of(
    library: Store, chosen: Iterable[int] | None, parts: Iterable[str], but: Capture | None = None
) -> tuple[Roster, Source]:
    """Return captures, and their movements ready to be laid out."""
    names = list(parts)
    roster, columns = library.columns(names, chosen, more=["swings"])
    places = np.flatnonzero(roster.number != (but.id if but is not None else 0))
    roster = roster.taken(places)
    rates = roster.rate[:, 0] / roster.rate[:, 1]
    own = {part: columns[part] for part in names}
    return roster, Source(own, places, roster.frames.astype(np.int64), rates)


def _hits(
    library: Store, query: Clips, roster: Roster, source: Source, near: list[Near]
) -> Iterator[Hit]:
    """Yield what is near as hits, with the symbols that correspond."""
    numbers = [int(roster.number[one.clip]) for one in near]
    found = {capture.id: (capture, held) for capture, held in library.tracks(numbers, query.parts)}
    for number, one in zip(numbers, near, strict=True):
        capture, tracks = found[number]
        clip = source.taken(np.array([one.clip]))
        whole = one.begin == 0 and one.end == capture.frames
        clip = clip if whole else clip.cut(0, one.begin, one.end)
        matched = [pairs(query, clip, part) for part in range(len(query.parts))]
        best = int(np.argmax([sum(pair.saving for pair in part) for part in matched]))
        listed = tracks[query.parts[best]].listed() if matched[best] else []
        symbols = [listed[clip.moves.rows[pair.row]] for pair in matched[best]]
        span = Span(0, capture.frames) if whole else _hull(clip, matched, one)
        yield Hit(capture, span, one.likeness, (tuple(symbols),))


def _hull(clip: Clips, matched: list[list[Pair]], one: Near) -> Span:
    """Return the frames from the first movement that corresponds to the end of the last."""
    rows = np.array([pair.row for part in matched for pair in part], np.int64)
    if not len(rows):
        return Span(one.begin, one.end)
    moves = clip.moves.taken(rows)
    return Span(int(moves.starts.min()), int(moves.stops.max()))
