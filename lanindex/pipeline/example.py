"""Captures that are alike: those like a clip, reordered by their joints if wanted, and groups.

A clip is like another by its symbols: the movements of its limbs.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lanindex import formats, locations
from lanindex.alphabet import kind_of
from lanindex.encoding.profile import load
from lanindex.errors import AbsentError, LanindexError, NotationError, UsageError, shown
from lanindex.library.connect import Progress
from lanindex.library.rows import Encoding
from lanindex.library.selection import is_number
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Reading, Span
from lanindex.model.columns import Roster, columns_of
from lanindex.notation import notation_of
from lanindex.pipeline.named import Named, from_file, ranged, stored
from lanindex.pipeline.prepare import as_ingested
from lanindex.pipeline.warping import Floats, normalised, warped
from lanindex.search.example.likeness import (
    Clips,
    ClipSource,
    Grouped,
    LargeSource,
    Near,
    Pair,
    Windows,
    aligned,
    grouped,
    nearest,
    pairs,
)
from lanindex.search.hits import Hits, ListedHits

if TYPE_CHECKING:
    from lanindex.pipeline.spread import Spread

RERANKED = 100
"""Hits of which files are read."""

ALIKE = 0.4
"""The mean likeness down to which groups are joined by default."""

SAMPLE = 2000
"""Captures that the command compares: of more, so many taken at random."""


def example(store: Store, clip: int | str | os.PathLike[str]) -> Named:
    """Return the clip that a person names, of the library or of a file elsewhere."""
    text = str(clip) if isinstance(clip, int) else locations.plain(clip)
    try:
        return stored(store, text)
    except AbsentError as error:
        path, _ = ranged(text)
        if not locations.is_file(path):
            if is_number(clip):
                raise
            found = f"there is no capture and no file {shown(path)}"
            raise UsageError(found, place="--like", remedy=error.remedy) from error
    profiles = {name: count for name, count in store.stats().profiles.items() if name}
    name = max(profiles, key=profiles.__getitem__, default="default")
    try:
        load(name)
    except NotationError as error:
        raise UsageError(
            f'the library is written down by the profile "{name}", which is not built in',
            place=f"--like {shown(text)}",
            remedy="Ingest the file with that profile, and name it as a capture of the library.",
        ) from error
    return from_file(text, Reading(), name)


def _laid_out(clip: Named) -> Clips:
    """Return the limbs of a clip that move or stand."""
    rate, end = clip.score.rate, clip.span.stop
    nobody = Capture(0, "", "", "", "", rate, end)
    limbs = {
        part: columns_of(part, [nobody], [track])
        for part, track in clip.score.tracks.items()
        if kind_of(part) == "gesture" and len(track)
    }
    only = np.zeros(1, np.int64)
    source = ClipSource(limbs, only, only + end, np.array([float(rate)]))
    clips = source.clips(only).cut(0, clip.span.start, end) if limbs else None
    if clips is None or not clips.moves.sizes.any():
        place = f"--like {shown(clip.named)}"
        raise UsageError("nothing moves there", place=place, wanted="one movement at least")
    return clips


@dataclass(frozen=True, slots=True)
class Alike:
    """What is like an example."""

    example: Named
    hits: Hits
    captures: int
    aligned: int
    sure: bool
    notes: tuple[str, ...] = ()


def alike(
    store: Store, clip: Named, numbers: Iterable[int] | None, limit: int, watch: Progress
) -> Alike:
    """Return the captures of a library that are most like a clip; its own is left out."""
    query = _laid_out(clip)
    asked = numbers, query.parts, clip.capture
    with suppress(_Changed):
        return _alike(store, clip, query, *_in_parts(store, *asked), limit, watch)
    return _alike(store, clip, query, *source_of(store, *asked), limit, watch)


def _alike(
    store: Store,
    clip: Named,
    query: Clips,
    roster: Roster,
    source: ClipSource | LargeSource,
    limit: int,
    watch: Progress,
) -> Alike:
    found = nearest(query, len(clip.span) / float(clip.score.rate), source, limit, watch=watch)
    hits = ListedHits(_hits(store, query, roster, source, found.near), f"like {clip.named}")
    return Alike(clip, hits, len(roster), found.aligned, found.sure)


class _Changed(Exception):
    """Somebody has written to the library between two parts of it that were read."""


def _in_parts(
    store: Store, numbers: Iterable[int] | None, parts: tuple[str, ...], but: Capture | None
) -> tuple[Roster, LargeSource]:
    """Return captures, and their movements, of which those of a part of them are in memory."""
    stamp, (roster, _) = store.stamp(), store.columns([], numbers)
    roster = roster.at(np.flatnonzero(roster.number != (but.id if but is not None else 0)))

    def read(places: NDArray[np.int64]) -> ClipSource:
        _, source = source_of(store, roster.number[places].tolist(), parts)
        if store.stamp() != stamp:
            raise _Changed
        return source

    rates = roster.rate[:, 0] / roster.rate[:, 1]
    return roster, LargeSource(roster.frames.astype(np.int64), rates, read)


def source_of(
    store: Store, numbers: Iterable[int] | None, parts: Iterable[str], but: Capture | None = None
) -> tuple[Roster, ClipSource]:
    """Return captures, and their movements ready to be laid out."""
    names = list(parts)
    roster, columns = store.columns(names, numbers, more=["swings"], kept=False)
    places = np.flatnonzero(roster.number != (but.id if but is not None else 0))
    roster = roster.at(places)
    rates = roster.rate[:, 0] / roster.rate[:, 1]
    limbs = {part: columns[part] for part in names}
    return roster, ClipSource(limbs, places, roster.frames.astype(np.int64), rates)


def _hits(
    store: Store,
    query: Clips,
    roster: Roster,
    source: ClipSource | LargeSource,
    near: list[Near],
) -> Iterator[Hit]:
    """Yield what is near as hits, with the symbols that correspond."""
    numbers = [int(roster.number[one.clip]) for one in near]
    held = {capture.id: (capture, tracks) for capture, tracks in store.tracks(numbers, query.parts)}
    places = np.unique(np.array([one.clip for one in near], np.int64))
    source = source.at(places)
    for number, one in zip(numbers, near, strict=True):
        capture, tracks = held[number]
        clip = source.clips(np.searchsorted(places, [one.clip]))
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
    moves = clip.moves.at(rows)
    return Span(int(moves.starts.min()), int(moves.stops.max()))


def reranked(store: Store, alike: Alike, watch: Progress) -> Alike:
    """Return those of the best hundred whose joints are known, by how far they lie from its own.

    The likeness is 1 less the mean distance in leg lengths, and no less than 0.
    """
    clip, hits, known = alike.example, alike.hits, store.known()
    capture = clip.capture
    location, digest = (capture.location, capture.sha256) if capture else (clip.path, "")
    try:
        wanted = _joints(location, digest, known, clip.span)
    except LanindexError as error:
        place = f"--like {shown(clip.named)} --rerank"
        raise UsageError(f"no joint positions: {error}", place=place) from error
    notes: list[str] = []
    ranked: list[tuple[float, Hit]] = []
    best = hits[:RERANKED]
    for done, hit in enumerate(best, 1):
        try:
            joints = _joints(hit.capture.location, hit.capture.sha256, known, hit.span)
            apart = warped(wanted, joints)
            if apart < inf:
                ranked.append((apart, replace(hit, fit=max(1 - apart, 0))))
            else:
                notes.append(f"{hit.path}: no joint is known in all frames of both")
        except LanindexError as error:
            notes.append(str(error))
        watch("files", done, len(best))
    moved = [hit for _, hit in sorted(ranked, key=itemgetter(0))]
    return replace(alike, hits=ListedHits(moved, hits.pattern), notes=tuple(notes))


def _joints(
    location: str, digest: str, known: Mapping[str, tuple[str, Encoding]], span: Span
) -> Floats:
    """Return the joints of a stretch of a file, as every body would do it."""
    if notation_of(location):
        raise UsageError("a score has no joints", place=location, wanted="a capture")
    file = formats.opened(location)
    _, encoding = known.get(location, ("", Encoding()))
    if digest and not as_ingested(file, digest, encoding):
        raise UsageError("has changed since it was ingested", place=location)
    reading = Reading(**encoding.options)
    motion = formats.read_file(file, reading, formats.Wanted(body_only=True))
    body = motion.skeleton.body
    joints = np.asarray(motion.positions[max(span.start, motion.first) : span.stop])[:, body]
    joints[:, body < 0] = np.nan
    return normalised(joints, float(motion.rate))


@dataclass(frozen=True, slots=True)
class Similar:
    """Captures that are like each other."""

    captures: tuple[Capture, ...]
    likeness: float


@dataclass(frozen=True, slots=True)
class Groups:
    """A library in groups."""

    groups: list[Similar]
    captures: int
    of: int
    pairs: int
    every: bool


def similar(
    store: Store,
    numbers: Iterable[int] | None,
    *,
    least: float,
    wanted: int | None,
    sample: int | None,
    watch: Progress,
    spread: Spread | None = None,
) -> Groups:
    """Return the captures of a library in groups."""
    if not 0 < least <= 1:
        raise UsageError(f"{least}", place="--alike", wanted="more than 0, 1 at the most")
    if wanted is not None and wanted < 1:
        raise UsageError(f"{wanted}", place="--groups", wanted="1 or more")
    limbs = [part for part in store.parts(checked=False) if kind_of(part) == "gesture"]
    every = store.columns([], numbers)[0].number
    roster, source = source_of(store, sampled(every, sample).tolist(), limbs)
    found = Grouped([], 0, True)
    if len(roster) and limbs:
        clips = source.clips(np.arange(len(roster)), watch)
        align = partial(_aligned, spread, watch) if spread else aligned
        found = grouped(clips, least=least, wanted=wanted, watch=watch, align=align)
    captures = store.captures_numbered(roster.number.tolist())
    groups = [
        Similar(tuple(captures[one] for one in group.members), group.likeness)
        for group in found.groups
    ]
    return Groups(groups, len(captures), len(every), found.pairs, found.every)


def _aligned(
    spread: Spread, watch: Progress, clips: Windows, keys: list[NDArray[np.int64]]
) -> Iterator[Floats]:
    """Align pairs of clips as `lanindex.search.example.likeness.aligned` does, elsewhere."""
    runs = np.array_split(np.arange(len(keys)), min(spread.tasks, len(keys)))
    items = [(clips, [keys[one] for one in run]) for run in runs]
    done, total = 0, sum(map(len, keys))

    def tick() -> None:
        watch("pairs", done, total)

    for (_, own), values in zip(items, spread.results(_align, items, tick), strict=True):
        yield from values
        done += sum(map(len, own))


def _align(item: tuple[Windows, list[NDArray[np.int64]]], tick: Callable[[], None]) -> list[Floats]:
    """Align pairs of clips in another process."""
    found = []
    for values in aligned(*item):
        tick()
        found.append(values)
    return found


def sampled(numbers: NDArray[np.int64], most: int | None) -> NDArray[np.int64]:
    """Return those of some captures that are looked at: (S,) int64, in order.

    They are drawn at random, since captures that follow each other may be alike, and the same ones
    each time.
    """
    if most is not None and most < 1:
        raise UsageError(f"a sample of {most}", wanted="1 or more")
    if most is None or len(numbers) <= most:
        return numbers
    return np.sort(np.random.default_rng(0).choice(numbers, most, replace=False))
