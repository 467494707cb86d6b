"""Search by example: captures like a clip by their symbols, the best reordered by their joints."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf

import numpy as np
from numpy.typing import NDArray

from lanindex import formats
from lanindex.alphabet import JOINT_CODES, kind_of
from lanindex.errors import (
    AbsentError,
    CaptureError,
    LanindexError,
    NotationError,
    UsageError,
    shown,
)
from lanindex.library.rows import Encoding
from lanindex.library.selection import is_number
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Reading, Span, Track
from lanindex.model.columns import Roster, columns_of
from lanindex.notation import notation_of
from lanindex.pipeline.deadline import Deadline
from lanindex.pipeline.named import ranged, stored, within
from lanindex.pipeline.prepare import as_ingested
from lanindex.search.example.align import Clips, Pair, Source, pairs
from lanindex.search.example.nearest import Near, nearest
from lanindex.search.hits import Hits, ListedHits

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


def example(store: Store, named: int | str | os.PathLike[str]) -> Example:
    """Return the clip that a person names."""
    text = str(named) if isinstance(named, int) else os.fspath(named)
    try:
        one = stored(store, text)
    except AbsentError as error:
        path, span = ranged(text)
        if not os.path.isfile(path):
            if is_number(named):
                raise
            found = f"there is no capture and no file {shown(path)}"
            raise UsageError(found, place="--like", remedy=error.remedy) from error
        return _read(store, path, text, span)
    path = one.capture.location if one.capture else one.path
    tracks, rate = one.score.tracks, float(one.score.rate)
    return Example(one.named, one.capture, path, tracks, rate, one.span)


def _read(store: Store, path: str, named: str, span: Span | None) -> Example:
    """Return a file's clip, written down as most captures of the library are."""
    from lanindex.encoding.profile import load
    from lanindex.pipeline.prepare import Task, prepare_one

    profiles = {name: count for name, count in store.stats().profiles.items() if name}
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
    notes: tuple[str, ...] = ()


def alike(
    store: Store,
    one: Example,
    chosen: Iterable[int] | None,
    limit: int = BEST,
    deadline: Deadline | None = None,
) -> Alike:
    """Return the captures of a library that are most like a clip; its own is left out."""
    query, watch = one.clip(), deadline or Deadline()
    roster, source = source_of(store, chosen, query.parts, one.capture)
    found = nearest(query, len(one.span) / one.rate, source, limit, watch=watch)
    hits = ListedHits(_hits(store, query, roster, source, found.near), f"like {one.named}")
    return Alike(one, hits, len(roster), found.aligned, found.sure)


def source_of(
    store: Store, chosen: Iterable[int] | None, parts: Iterable[str], but: Capture | None = None
) -> tuple[Roster, Source]:
    """Return captures, and their movements ready to be laid out."""
    names = list(parts)
    roster, columns = store.columns(names, chosen, more=["swings"])
    places = np.flatnonzero(roster.number != (but.id if but is not None else 0))
    roster = roster.taken(places)
    rates = roster.rate[:, 0] / roster.rate[:, 1]
    own = {part: columns[part] for part in names}
    return roster, Source(own, places, roster.frames.astype(np.int64), rates)


def _hits(
    store: Store, query: Clips, roster: Roster, source: Source, near: list[Near]
) -> Iterator[Hit]:
    """Yield what is near as hits, with the symbols that correspond."""
    numbers = [int(roster.number[one.clip]) for one in near]
    found = {capture.id: (capture, held) for capture, held in store.tracks(numbers, query.parts)}
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


Floats = NDArray[np.float32]

MOST = 100
"""Hits of which files are read."""

RATE = 30
"""Frames a second that are compared at the most."""


def reranked(store: Store, found: Alike, deadline: Deadline | None = None) -> Alike:
    """Return what is like an example, the best hundred by how far their joints lie from its own."""
    one, hits = found.example, found.hits
    known = store.known()
    digest = one.capture.sha256 if one.capture else ""
    location = one.capture.location if one.capture else one.path
    try:
        own = _joints(location, digest, known, one.span)
    except LanindexError as error:
        place = f"--like {shown(one.named)} --rerank"
        raise UsageError(f"no joint positions: {error}", place=place) from error
    notes: list[str] = []
    apart: list[float] = []
    watch, best = deadline or Deadline(), hits[:MOST]
    for done, hit in enumerate(best):
        watch("files", done, len(best))
        try:
            joints = _joints(hit.capture.location, hit.capture.sha256, known, hit.span)
            apart.append(warped(own, joints))
            if apart[-1] == inf:
                notes.append(f"{hit.path}: no joint is known in all frames of both")
        except LanindexError as error:
            notes.append(str(error))
            apart.append(inf)
    order = sorted(range(len(apart)), key=apart.__getitem__)
    moved = hits.arranged([*order, *range(len(order), len(hits))])
    return replace(found, hits=moved, notes=tuple(notes))


def _joints(
    location: str, digest: str, known: dict[str, tuple[str, Encoding]], span: Span
) -> NDArray[np.float32]:
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


def normalised(joints: NDArray[np.float32], rate: float) -> Floats:
    """Return joints (T, 20, 3), mm, as any body would move anywhere: (U, 20, 3) in leg lengths.

    At most `RATE` frames a second, seen from between the hips, which are turned to lie along z.
    """
    step = max(1.0, rate / RATE)
    kept = joints[np.floor(np.arange(0, len(joints), step)).astype(np.int64)].astype(np.float64)
    right, left = kept[:, JOINT_CODES["RHip"]], kept[:, JOINT_CODES["LHip"]]
    kept -= ((right + left) / 2)[:, None]
    across = right - left
    turn = np.arctan2(across[:, 0], across[:, 2])[:, None]
    x, z = kept[..., 0].copy(), kept[..., 2].copy()
    kept[..., 0] = np.cos(turn) * x - np.sin(turn) * z
    kept[..., 2] = np.sin(turn) * x + np.cos(turn) * z
    chain = kept[:, [JOINT_CODES[name] for name in ("RHip", "RKnee", "RAnkle")]]
    leg = np.linalg.norm(np.diff(chain, axis=1), axis=2).sum(axis=1)
    known = leg[np.isfinite(leg)]
    kept /= np.median(known) if len(known) else np.nan
    return np.asarray(kept, np.float32)


def warped(one: Floats, two: Floats) -> float:
    """Return how far joints lie apart on the cheapest way through two `normalised` clips.

    In leg lengths, the mean over joints and frames of both; infinity where no joint is known in all
    frames of both.
    """
    known = np.isfinite(one).all(axis=(0, 2)) & np.isfinite(two).all(axis=(0, 2))
    if not known.any() or not len(one) or not len(two):
        return float("inf")
    apart = _apart(one[:, known], two[:, known])
    return _cheapest(apart) / (len(one) + len(two))


def _apart(one: Floats, two: Floats) -> NDArray[np.float64]:
    """Return the mean distance of joints for each pair of frames: (T, U)."""
    total: NDArray[np.float64] = np.zeros((len(one), len(two)))
    for joint in range(one.shape[1]):
        here, there = one[:, joint].astype(np.float64), two[:, joint].astype(np.float64)
        squares = np.square(here).sum(axis=1)[:, None] + np.square(there).sum(axis=1)
        squares -= 2 * here @ there.T
        total += np.sqrt(np.maximum(squares, 0, out=squares), out=squares)
    total /= one.shape[1]
    return total


def _cheapest(apart: NDArray[np.float64]) -> float:
    """Return the cost of the cheapest way, in which a step forward in both counts twice."""
    first, *rows = apart
    cost = np.cumsum(first)
    cost += first[0]
    for row in rows:
        reach = np.cumsum(row)
        arrived = cost + row
        arrived[1:] = np.minimum(arrived[1:], cost[:-1] + 2 * row[1:])
        # A way along the row adds up what it passes: a running minimum of what is left without.
        cost = np.minimum.accumulate(arrived - reach) + reach
    return float(cost[-1])


def sampled(count: int, most: int | None) -> NDArray[np.int64]:
    """Return the places of the captures that are looked at: (S,) int64, in order.

    They are drawn at random, since captures that follow each other may be alike, and the same ones
    each time.
    """
    if most is not None and most < 1:
        raise UsageError(f"a sample of {most}", wanted="1 or more")
    if most is None or count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).choice(count, most, replace=False))
