"""Queries, words of the dictionary that stand for one, and the search for them."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from math import inf
from os import PathLike
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import FACING, MEASURES, TRACKS, mirrored_part
from lanindex.errors import LanindexError, LibraryError, OutOfMemoryError, PatternError, UsageError
from lanindex.library.connect import Session
from lanindex.library.store import Store
from lanindex.model import Capture, Score, Symbol, Track
from lanindex.model.columns import STARTING, columns_of, roster_of
from lanindex.search.dictionary import Entry, entry_named, load, named_patterns, spelled, words_of
from lanindex.search.hits import CLIP_FIELDS, Found, Hits, extras_in
from lanindex.search.language import parse
from lanindex.search.language.clauses import CLIP, Reference
from lanindex.search.language.natural import reading
from lanindex.search.language.words import LANGUAGE, VALUES, Vocabulary
from lanindex.search.match.finder import NARROWER, Finder, Recording, Watch, find_in

if TYPE_CHECKING:
    from lanindex.model.columns import Columns, Roster
    from lanindex.search.explain.advice import Advice, HitCounts
    from lanindex.search.fuzzy import Allowance, FuzzyHits
    from lanindex.search.language.query import Query
    from lanindex.search.match import ExactHits
    from lanindex.search.match.finder import Recordings

NEAR = 250
"""How far out the border of a cell lies with ``--near``, in thousandths of a margin."""

_NAMED = re.compile(r"@(\w+)")

MOST_NAMED = 5
"""Captures that are named, of those that are too rich for a pattern."""


@dataclass(frozen=True, slots=True)
class SearchOptions:
    """How a search is made; `memory` is in bytes."""

    tolerance: Fraction = Fraction(1, 10)
    overlaps: str = "none"
    near: int = 0
    allowance: Allowance | None = None
    best: int | None = None
    memory: int | None = None

    @classmethod
    def read(
        cls,
        tolerance: float = 0.1,
        overlaps: str = "none",
        near: bool = False,
        fuzzy: str | float | None = None,
        best: int | None = None,
        memory: float | None = None,
    ) -> Self:
        """Return the options of `Library.search`."""
        if not 0 <= tolerance < inf:
            raise UsageError(f"a tolerance of {tolerance} s", wanted="0 or more")
        if overlaps not in ("none", "all"):
            raise UsageError(f'overlaps "{overlaps}"', wanted="none or all")
        allowance = None
        if fuzzy is not None:
            from lanindex.search.fuzzy import Allowance

            allowance = Allowance.read(str(fuzzy))
        limit = None if memory is None else int(memory * 1e6)
        return cls(Fraction(str(tolerance)), overlaps, NEAR if near else 0, allowance, best, limit)

    def find(
        self,
        query: Query,
        roster: Roster,
        columns: Mapping[str, Columns],
        recordings: Recordings,
        watch: Watch,
        refused: list[LanindexError],
        found: Found | None = None,
    ) -> Hits:
        """Find a query in columns; errors of captures that are too rich for it go to `refused`."""
        finder = self.finder(query, roster, columns, recordings)
        return self.found_by(finder, watch, refused, found)

    def finder(
        self, query: Query, roster: Roster, columns: Mapping[str, Columns], recordings: Recordings
    ) -> Finder:
        """Return what finds a query in columns, and makes objects of its hits."""
        query = replace(query, near=self.near)
        return Finder(query, roster, columns, recordings, self.tolerance, self.memory)

    def found_by(
        self,
        finder: Finder,
        watch: Watch,
        refused: list[LanindexError],
        found: Found | None = None,
    ) -> ExactHits | FuzzyHits:
        """Return what a finder finds; errors as of `find`."""
        if self.allowance is None:
            return finder.find(self.overlaps, watch, self.best, refused, found=found)
        from lanindex.search import fuzzy

        return fuzzy.find(
            finder, self.allowance, self.overlaps, watch, self.best, refused, found=found
        )


def query_of(
    text: str,
    parts: Collection[str] | None = None,
    words: str | PathLike[str] | None = None,
    *,
    strict: bool = False,
) -> Query:
    """Read a query, or the pattern that it names, for captures with some parts."""
    entry = entry_of_query(text, words)
    pattern = entry.pattern if entry else text
    return parse(pattern, parts, names=named_patterns(pattern, words), strict=strict)


def entry_of_query(text: str, words: str | PathLike[str] | None = None) -> Entry | None:
    """Return the entry that a whole query names: ``walk``, ``@walk``, ``a person walks``.

    Where the words have a meaning in the language as well, they are left to it, but for words of
    one's own.
    """
    name, known = spelled(text), load(words)
    if Vocabulary().mover(text.strip().lower()) is not None and known.get(name) == load().get(name):
        return None
    if name in known:
        return known[name]
    return entry_named(text, known) if words_of(text) and reading(text) is None else None


def unknown(text: str) -> str:
    """Return the one word of a query that means nothing, neither alone nor in a pattern."""
    name = spelled(text)
    one = name.isidentifier() and len(text.split()) == 1
    means = name in LANGUAGE or name in VALUES or Vocabulary().mover(name) is not None
    return name if one and not means else ""


def search(
    store: Store,
    query: Query,
    numbers: Sequence[int] | None,
    options: SearchOptions,
    watch: Watch,
    refused: list[LanindexError],
    note: Callable[[str], None],
    found: Found | None = None,
) -> Hits:
    """Find a pattern in a library; errors of captures that are too rich for it go to `refused`."""
    if options.allowance is not None:
        from lanindex.search import fuzzy

        fuzzy.plans_of(query, options.allowance)  # raises, before anything is noted
    extras = extras_in(query)
    tick = partial(watch, 0, 0)  # how many captures there are is not known yet
    roster, columns = store.columns(query.parts, numbers, more=extras, tick=tick)
    unmeasured = count_unmeasured(len(roster), columns, extras)
    note_lacking(note, query, len(roster), moving_parts(columns), unmeasured)
    rich: list[LanindexError] = []
    with out_of_memory(store.place):
        recordings = recordings_of(store, partial(match_columns, roster, columns), roster.number)
        hits = options.find(query, roster, columns, recordings, watch, rich, found)
        note_refused_captures(note, rich, refused)
    return hits


@contextmanager
def out_of_memory(place: str) -> Iterator[None]:
    """Raise a search's lack of memory as an error that tells what to do."""
    with suppress(MemoryError):  # which is gone at the end of this, and so is what it held
        yield
        return
    raise OutOfMemoryError("the search ran out of memory", place=place, remedy=NARROWER)


def note_lacking(
    note: Callable[[str], None],
    query: Query,
    captures: int,
    moving: Collection[str],
    unmeasured: int,
) -> None:
    """Note what a query asks of captures, and none or few of them tell."""
    if captures and (absent := _absent_parts(query.parts, moving)):
        palms = any(part in FACING for part in absent)
        hint = ": few captures tell where palms face (lanindex inspect FILE)" if palms else ""
        note(f"no capture that was searched has symbols of {', '.join(absent)}{hint}")
    if unmeasured:
        measures = " or ".join(sorted(extras_in(query) - {"swings"}))
        note(
            f"{unmeasured} of {captures} captures tell no {measures}: they came "
            "as scores, or from an earlier version, and want to be ingested anew"
        )


def note_refused_captures(
    note: Callable[[str], None], errors: Sequence[LanindexError], refused: list[LanindexError]
) -> None:
    """Note errors of captures that are too rich for a pattern, and keep them."""
    for line in too_rich(errors):
        note(line)
    refused += errors


def too_rich(errors: Sequence[LanindexError]) -> Iterator[str]:
    """Yield a line for each capture that is too rich for a pattern; of many, for the first ones."""
    yield from map(str, errors[:MOST_NAMED])
    if more := errors[MOST_NAMED:]:
        yield f"{len(more)} more captures are too rich for this pattern"


def moving_parts(columns: Mapping[str, Columns]) -> set[str]:
    """Return the parts that have symbols."""
    return {part for part, one in columns.items() if len(one)}


def _absent_parts(parts: Collection[str], moving: Collection[str]) -> list[str]:
    """Return the parts without symbols in any capture; of a pair, only if both sides have none."""
    blank = {*parts}.difference(moving)
    return [part for part in TRACKS if part in blank and mirrored_part(part) not in moving]


def count_unmeasured(captures: int, columns: Mapping[str, Columns], extras: Collection[str]) -> int:
    """Count the captures whose movements of some parts all lack the measures of `extras`."""
    moving, known = np.zeros(captures, np.bool_), np.zeros(captures, np.bool_)
    for one in columns.values():
        held = [getattr(one, name) for name in MEASURES if name in extras]
        held = [values for values in held if values is not None]
        if held:
            owner = np.repeat(np.arange(captures), np.diff(one.bounds))
            moving[owner[one.cell < STARTING]] = True
            known[owner[np.logical_and.reduce([values > 0 for values in held])]] = True
    return int((moving & ~known).sum())


Matching = Callable[[Sequence[int], Collection[str], Sequence[Recording]], bool]
"""Returns whether captures, by their places in a roster, are as they were when they were searched,
and so are their tracks of some parts."""


def recordings_of(store: Store, matching: Matching, numbers: NDArray[np.int64]) -> Recordings:
    """Return what fetches captures with some of their tracks, by their places in a roster.

    They are compared with what was searched: a hit refers to rows, and these may be others by now,
    since the library has changed or is damaged. `numbers` (C,) are those of the roster.
    """

    def recordings(places: Sequence[int], parts: Collection[str]) -> Sequence[Recording]:
        wanted = numbers[list(places)].tolist()
        with (
            nullcontext(store)
            if store.session.is_open
            else type(store)(Session(store.session.target, readonly=True)) as opened
        ):
            found: list[Recording]
            if parts:
                found = list(opened.tracks(wanted, parts, listed=False))
            else:
                found = [(capture, {}) for capture in opened.captures_numbered(wanted)]
            if matching(places, parts, found):
                return found
            # listed once more, which raises an error where a track is damaged
            held = {one.id: (one, tracks) for one, tracks in opened.tracks(wanted, parts)}
        same = [
            one in held and matching([place], parts, [held[one]])
            for place, one in zip(places, wanted, strict=True)
        ]
        raise LibraryError(
            f"{same.count(False)} captures with hits are gone, or others now",
            place=store.place,
            remedy="Search again: the library has changed since.",
        )

    return recordings


def match_columns(
    roster: Roster,
    columns: Mapping[str, Columns],
    places: Sequence[int],
    parts: Collection[str],
    recordings: Sequence[Recording],
) -> bool:
    """Return whether captures are as the columns have them, and so are some of their tracks."""
    rows, captures = np.array(places, np.int64), [capture for capture, _ in recordings]
    return roster_of(captures).same_as(roster.at(rows)) and all(
        columns_of(part, captures, [tracks.get(part) for _, tracks in recordings]).same_as(
            columns[part].at(rows)
        )
        for part in parts
        if part in columns
    )


def check_columns(store: Store, references: Iterable[Reference]) -> None:
    """Refuse a column that no capture has: it would meet no condition, without a word."""
    named = {it.field for it in references if it.name == CLIP} - set(CLIP_FIELDS)
    metadata = store.texts("metadata").values() if named else ()
    known = {column.lower() for columns in metadata for column in columns}
    if metadata and (lacking := sorted(named - known)):
        wanted = f"clip and one of {', '.join([*CLIP_FIELDS, *sorted(known)])}"
        raise UsageError(f'no capture has a column "{lacking[0]}"', wanted=wanted)


def suggest(
    store: Store,
    query: Query,
    numbers: Sequence[int] | None,
    options: SearchOptions,
    refused: list[LanindexError],
) -> Advice:
    """Return what to do about a query that finds nothing."""
    from lanindex.search.explain.advice import SECONDS, Advice, Budget, LeftOut, advise

    query, budget = replace(query, stages=()), Budget(SECONDS)  # a pipe finds nothing by itself
    parts = store.parts(checked=False)
    rich: dict[str, LanindexError] = {}

    def watch(*_: int) -> None:
        if budget.late():
            raise TimeoutError

    def count(query: Query, among: Sequence[int] | None = numbers) -> HitCounts | None:
        errors: list[LanindexError] = []
        try:
            watch()
            roster, columns = store.columns(query.parts, among, more=extras_in(query))

            def recordings(places: Sequence[int], parts: Collection[str]) -> Iterator[Recording]:
                for recording in store.tracks(roster.number[list(places)].tolist(), parts):
                    watch()
                    yield recording

            hits = options.find(query, roster, columns, recordings, watch, errors)
            counts = len(hits), hits.captures
        except (TimeoutError, LanindexError):  # or no edits are allowed in it
            return None
        rich.update({error.place: error for error in errors})
        return counts

    def read(text: str) -> Query | None:
        try:
            return parse(text, parts)
        except PatternError:
            return None

    elsewhere = None if numbers is None else count(query, None)
    roster, _ = store.columns(query.parts, numbers)
    if len(roster):
        advice = advise(query, count, read, budget=budget)
    else:
        fitting = "" if numbers is None else " that fits --in and --where"
        advice = Advice(str(query), remark=f"There is no capture{fitting}.")
    if elsewhere and elsewhere[0]:
        advice = replace(advice, left_out=(LeftOut("", *elsewhere), *advice.left_out))
    note_refused_captures(store.session.note, list(rich.values()), refused)
    return advice


def in_words(advice: Advice, text: str, words: str | PathLike[str] | None) -> Advice:
    """Return advice on a query that has ``@walk``, and not the whole pattern of that word."""
    names, known = named_patterns(text, words), dict[str, str]()
    for name in names.keys() & set(_NAMED.findall(text)):
        with suppress(PatternError):  # it has no part of its own
            known[f"({parse(names[name]).pattern})"] = f"@{name}"

    def named(text: str) -> str:
        for pattern, name in known.items():
            text = text.replace(pattern, name)
        return text

    left_out = (
        replace(it, condition=named(it.condition), step=named(it.step), pattern=named(it.pattern))
        for it in advice.left_out
    )
    instead = (replace(it, pattern=named(it.pattern)) for it in advice.instead)
    never = tuple(map(named, advice.never))
    return replace(advice, never=never, left_out=tuple(left_out), instead=tuple(instead))


def searcher(
    captures: Sequence[Capture], tracks: Sequence[Mapping[str, Track]], options: SearchOptions
) -> Callable[[Query, Watch, list[LanindexError]], Hits]:
    """Return what searches some captures for a query; its columns are made once."""
    roster = roster_of(captures)
    columns: dict[str, Columns] = {}

    def recordings(places: Sequence[int], parts: Collection[str]) -> list[Recording]:
        return [(captures[place], tracks[place]) for place in places]

    def search(query: Query, watch: Watch, refused: list[LanindexError]) -> Hits:
        for part in set(query.parts) - columns.keys():
            columns[part] = columns_of(part, captures, [one.get(part) for one in tracks])
        used = {part: columns[part] for part in query.parts}
        found = options.find(query, roster, used, recordings, watch, refused)
        return found.of(str(query))

    return search


def matched(
    score: Score, pattern: str, words: str | PathLike[str] | None = None
) -> list[list[Symbol]]:
    """Return the symbols of each hit of a pattern in a score."""
    query = query_of(pattern, list(score.tracks), words)
    if query.stages:
        raise UsageError(f'"| {query.stages[0]}"', wanted="a pattern without a pipe")
    capture = Capture(1, "score", "lnd", "", "", Fraction(score.rate), score.frames, score.meter)
    return [list(hit.symbols) for hit in find_in([(capture, score.tracks)], query)]
