"""The hits of a search, as objects, dictionaries, columns or a table; their counts and fields."""

from __future__ import annotations

import operator
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module
from operator import attrgetter
from typing import Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from lanindex import records
from lanindex.alphabet import KINDS, LEVEL_CODES, LEVELS, kind_of
from lanindex.errors import UsageError
from lanindex.model import Capture, Hit, Span, Symbol
from lanindex.model.capture import in_words, readable
from lanindex.model.columns import EXTRA, GRADES
from lanindex.model.derived import Amount, degree_of
from lanindex.model.score import Tabular
from lanindex.search.language import clauses
from lanindex.search.language.clauses import CLIP, MATCH, Reference
from lanindex.search.language.query import Query, Step, Word, nodes_in
from lanindex.search.language.times import Clock, Time
from lanindex.search.language.words import AMOUNTS, STILL
from lanindex.search.limits import tick

IntArray = NDArray[np.int64]

FEW = 10  # hits that are shown of many
TOGETHER = 512  # captures that are fetched at once where all hits are made objects


class Hits(Sequence[Hit], Tabular):
    """The hits of a search, in order, and the pattern that was searched for.

    They are columns; a `Hit` object is made on access.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     hits = library.search("torso forward high -> hold 1s+")
    >>> len(hits), hits.pattern
    (1, 'torso forward high -> hold 1s+')
    >>> hits[0].capture.label, hits[0].span
    ('greeting', Span(start=482, stop=602))
    >>> [span.start for _, span in hits.spans()], len(hits.arranged([0, 0])), hits.counts()[0][1]
    ([482], 2, 1)
    >>> hits.to_arrow().num_rows, list(hits.to_pandas())[:2], list(hits.to_frame())[2]
    (1, ['capture', 'capture_id'], 'label')
    >>> hits.columns()["start_frame"]
    [482]
    >>> hits.html_table().startswith("<table><caption>1 hit in 1 capture: ")
    True
    >>> hits.tally()
    [(4, 1)]
    >>> hits.by_fit()[0] == hits[0], hits.dicts()[0]["start_frame"], hits.numpy()["stop"]
    (True, 482, array([602]))
    >>> hits.at([0]).pattern, hits.at([0]).of("a rest").pattern, hits.clear().shape
    ('torso forward high -> hold 1s+', 'a rest', (1,))
    """

    pattern = ""

    def __init__(
        self,
        captures_at: Callable[[Sequence[int]], list[Capture]],  # by their places in the roster
        numbers: IntArray,  # (C,) of the captures in the roster
        place: IntArray,  # (H,) of the capture in the roster
        low: IntArray,  # (H,) frames of the source, half-open
        high: IntArray,
    ) -> None:
        self._captures_at, self._numbers = captures_at, numbers
        self.place, self.low, self.high = place, low, high

    @abstractmethod
    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        """Return some hits as objects."""

    @abstractmethod
    def _subset(self, rows: NDArray[Any] | slice) -> Self:
        """Return some of the rows, in any order, without the pattern."""

    @abstractmethod
    def clear(self) -> NDArray[np.float64]:
        """Return how clear each hit is, (H,) from 0 to 1."""

    def of(self, pattern: str) -> Self:
        """Name the pattern that was searched for, and return the hits."""
        self.pattern = pattern
        return self

    def at(self, chosen: NDArray[Any] | slice) -> Self:
        """Return some of them, in any order."""
        return self._subset(chosen).of(self.pattern)

    def __len__(self) -> int:
        return len(self.place)

    @overload
    def __getitem__(self, index: int) -> Hit: ...
    @overload
    def __getitem__(self, index: slice) -> Self: ...
    def __getitem__(self, index: int | slice) -> Hit | Self:
        if isinstance(index, slice):
            return self.at(index)
        return self._hits([range(len(self))[index]])[0]

    def __iter__(self) -> Iterator[Hit]:
        """Yield them in order; captures are fetched many at once."""
        first, places = 0, set[int]()
        for index, place in enumerate([*self.place.tolist(), -1] if len(self) else []):
            if place < 0 or (len(places) == TOGETHER and place not in places):
                yield from self._hits(range(first, index))
                first, places = index, set()
            places.add(place)

    @property
    def captures(self) -> int:
        """How many captures have hits."""
        return len(self._per_capture()[0])

    def tally(self) -> list[tuple[int, int]]:
        """Return the numbers of the captures, each with how many hits it has."""
        places, counts = self._per_capture()
        return list(zip(self._numbers[places].tolist(), counts.tolist(), strict=True))

    def counts(self) -> list[tuple[Capture, int]]:
        """Return the captures, each with how many hits it has."""
        places, counts = self._per_capture()
        return list(zip(self._captures(places), counts.tolist(), strict=True))

    def _captures(self, places: IntArray) -> Iterator[Capture]:
        """Yield captures by their places in the roster, many fetched at once."""
        for first in range(0, len(places), TOGETHER):
            tick()
            yield from self._captures_at(places[first : first + TOGETHER].tolist())

    def _per_capture(self) -> tuple[IntArray, IntArray]:
        """Return the captures of hits, in order, and how many each has."""
        ordered = np.sort(self.place)  # np.unique imports as much as all of a small search takes
        firsts = np.flatnonzero(np.diff(ordered, prepend=-1))
        return ordered[firsts], np.diff(firsts, append=len(ordered))

    def spans(self) -> Iterator[tuple[Capture, Span]]:
        """Yield capture and frames of each hit, in order."""
        places = self._per_capture()[0]
        captures = dict(zip(places.tolist(), self._captures(places), strict=True))
        columns = (self.place.tolist(), self.low.tolist(), self.high.tolist())
        for place, low, high in zip(*columns, strict=True):
            yield captures[place], Span(low, high)

    def arranged(self, order: Sequence[int]) -> Self:
        """Return the same hits in another order: that of these numbers, counted from 0."""
        return self.at(np.array(order, np.int64))

    def by_fit(self, most: int | None = None) -> Self:
        """Return the same hits, the clearest first; behind the first `most`, in any order."""
        return self.at(np.argsort(-self.clear(), kind="stable"))

    def numpy(self) -> NDArray[Any]:
        """Return (H,) with the fields capture_id, start, stop (frames, half-open) and fit."""
        fields = [("capture_id", "i8"), ("start", "i8"), ("stop", "i8"), ("fit", "f4")]
        rows = np.empty(len(self), fields)
        rows["capture_id"] = self._numbers[self.place]
        rows["start"], rows["stop"], rows["fit"] = self.low, self.high, self.clear()
        return rows

    def __repr__(self) -> str:
        lines = [f"  {readable(hit.path)}  {hit.when}, fit {hit.fit:.2f}" for hit in self[:FEW]]
        return "\n".join(
            [f"<{self._counts()}: {readable(self.pattern)}>", *lines, *self._more_line()]
        )

    def _repr_html_(self) -> str:
        """Return the first hits with pictures, which a notebook shows."""
        notebook = import_module("lanindex.film.notebook")
        return str(notebook.of_hits(self.html_table(), self[:FEW]))

    def html_table(self) -> str:
        """Return the first hits as an HTML table, without pictures."""
        from html import escape

        def cells(kind: str, *texts: str) -> str:
            tagged = (f"<{kind}>{escape(readable(text))}</{kind}>" for text in texts)
            return f"<tr>{''.join(tagged)}</tr>"

        rows = [
            cells("td", hit.path, hit.capture.label, hit.when, f"{hit.fit:.2f}", words)
            for hit in self[:FEW]
            for words in [", ".join(in_words(hit.symbols))]
        ]
        head = cells("th", "capture", "label", "frames and seconds", "fit", "symbols")
        caption = escape(f"{self._counts()}: {readable(self.pattern)}")
        more = "".join(f"<p>{line.strip()}</p>" for line in self._more_line())
        return f"<table><caption>{caption}</caption>{head}{''.join(rows)}</table>{more}"

    def _counts(self) -> str:
        captures = self.captures
        return f"{len(self)} hit{'s'[: len(self) != 1]} in {captures} capture{'s'[: captures != 1]}"

    def _more_line(self) -> list[str]:
        if not len(self):
            return ["  library.suggest(pattern) tells what is near"]
        return [f"  ... {len(self) - FEW} more"] if len(self) > FEW else []

    def dicts(self) -> list[dict[str, Any]]:
        """Return the hits as dictionaries, as the command prints with ``--json``."""
        return [records.of_hit(hit, self.pattern) for hit in self]

    def columns(self) -> dict[str, list[Any]]:
        """Return the columns of `dicts`, a row a hit."""
        rows = self.dicts()
        return {key: [row[key] for row in rows] for key in records.HIT}


Found = Callable[[Sequence[Hits]], None]
"""Called with the hits found so far in pieces, in order of capture, while a search goes on."""


class ListedHits(Hits):
    """Hits that are objects already."""

    def __init__(self, hits: Iterable[Hit], pattern: str) -> None:
        self._listed = list(hits)
        captures = {hit.capture.id: hit.capture for hit in self._listed}
        places = {number: place for place, number in enumerate(captures)}
        rows = [(places[it.capture.id], it.span.start, it.span.stop) for it in self._listed]
        columns = np.array(rows, np.int64).reshape(-1, 3).T
        held, numbers = list(captures.values()), np.array(list(captures), np.int64)
        super().__init__(lambda places: [held[it] for it in places], numbers, *columns)
        self.pattern = pattern

    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        return [self._listed[index] for index in indices]

    def _subset(self, rows: NDArray[Any] | slice) -> ListedHits:
        return ListedHits(self._hits(np.arange(len(self))[rows].tolist()), "")

    def clear(self) -> NDArray[np.float64]:
        """Return the fit of each hit, (H,) from 0 to 1."""
        return np.array([hit.fit for hit in self._listed], np.float64)


@dataclass(frozen=True, slots=True)
class Counted:
    """How many hits have one value of a field."""

    value: str | float | None  # times in seconds; None where it is missing, or all are counted
    count: int


class Counts(Sequence[Counted]):
    """How many hits of a pattern there are, or how many for each value of a field, in order.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     counts = library.search("arms place high | count by clip.label | first 2")
    >>> for one in counts:
    ...     print(one.value, one.count)
    radio gymnastics 4
    port de bras 1
    >>> counts.total, counts.dicts()[0]
    (5, {'by': 'clip.label', 'value': 'radio gymnastics', 'count': 4})
    """

    def __init__(self, counts: Iterable[Counted], pattern: str, by: Reference | None) -> None:
        self._counts = tuple(counts)
        self.pattern, self.by = pattern, by

    @overload
    def __getitem__(self, index: int) -> Counted: ...
    @overload
    def __getitem__(self, index: slice) -> Counts: ...
    def __getitem__(self, index: int | slice) -> Counted | Counts:
        if isinstance(index, slice):
            return Counts(self._counts[index], self.pattern, self.by)
        return self._counts[index]

    def __len__(self) -> int:
        return len(self._counts)

    def __bool__(self) -> bool:
        """Return whether anything was counted."""
        return self.total > 0

    def __repr__(self) -> str:
        lines = [f"  {readable(str(one.value))}  {one.count}" for one in self._counts[:FEW]]
        hits = f"{self.total} hit{'s'[: self.total != 1]}{f' by {self.by}' if self.by else ''}"
        head = f"<{hits}: {readable(self.pattern)}>"
        return "\n".join([head, *(lines if self.by else [])])

    @property
    def total(self) -> int:
        """All of them together."""
        return sum(one.count for one in self._counts)

    def dicts(self) -> list[dict[str, Any]]:
        """Return them as dictionaries, as the command prints with ``--json``."""
        by = str(self.by) if self.by else None
        return [{"by": by, "value": one.value, "count": one.count} for one in self._counts]


def piped(stages: Sequence[clauses.Stage], result: Hits | Counts) -> Hits | Counts:
    """Return what the stages of a pipe make of hits, which come by capture, start and end."""
    for stage in stages:
        if stage.verb == "first":
            result = result[: stage.most]
        elif isinstance(result, Hits) and stage.verb == "sort" and stage.by:
            result = result.at(_sorted(order(stage.by, it) for it in _values(result, stage.by)))
        elif isinstance(result, Hits):
            result = counted([result], result.pattern, stage.by)
    return result


def _sorted(orders: Iterable[tuple[Any, ...]]) -> IntArray:
    """Return the places of some keys in their order; each different one is compared once."""
    numbers: dict[tuple[Any, ...], int] = {}
    numbered = [numbers.setdefault(key, len(numbers)) for key in orders]
    ranks = np.empty(len(numbers), np.int64)
    ranks[[numbers[key] for key in sorted(numbers)]] = np.arange(len(numbers))
    return np.argsort(ranks[np.array(numbered, np.int64)], kind="stable")


def hits_in(hits: Hits | Counts) -> Hits:
    """Return the hits; refuse counts, which have no clips."""
    if isinstance(hits, Counts):
        raise UsageError("hits that are only counted", wanted='a pattern without "| count"')
    return hits


def _values(hits: Hits, by: Reference) -> Iterator[Value]:
    """Yield a field of each hit, without making objects where it can."""
    if is_of_span(by):
        for number, (capture, span) in enumerate(hits.spans()):
            if not number % TOGETHER:
                tick()
            yield value_of_span(by, capture, span)
    else:
        yield from (value_of(by, hit) for hit in hits)


def counted(pieces: Iterable[Hits], pattern: str, by: Reference | None) -> Counts:
    """Return how many hits there are in some pieces, or how many for each value of a field."""
    if by is None:
        return Counts([Counted(None, sum(map(len, pieces)))], pattern, None)
    numbers = Counter[Value]()
    for hits in pieces:
        if by.name == CLIP:  # the same for all hits of a capture
            for capture, count in hits.counts():
                numbers[value_of_span(by, capture, Span(0, 0))] += count
        else:
            numbers.update(_values(hits, by))
    ordered = sorted(numbers, key=lambda value: (-numbers[value], order(by, value)))
    return Counts([Counted(_json_value(it), numbers[it]) for it in ordered], pattern, by)


def _json_value(value: Value) -> str | float | None:
    if value is None or isinstance(value, str):
        return value
    return int(value) if value.denominator == 1 else round(float(value), 6)


# Fields of hits and captures, which `where` compares and a pipe sorts and counts by.

Value = str | Fraction | None  # times in seconds; no condition holds of a missing value

COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "!=": operator.ne,
}

_CLIP: dict[str, Callable[[Capture], str | Fraction]] = {
    **{name: attrgetter(name) for name in ("path", "label", "format", "sha256")},
    "fps": lambda capture: capture.rate,
    "frames": lambda capture: Fraction(capture.frames),
    "seconds": lambda capture: capture.frames / capture.rate,
    "tempo": lambda capture: capture.meter.speed,
}

CLIP_FIELDS = tuple(_CLIP)
"""Fields of every capture; its other columns have the names that the user gave."""

_TIMES = ("start", "end", "length")
_EIGHTH = 45  # degrees of an eighth of a turn


def names_in(conditions: Collection[clauses.Condition]) -> frozenset[str]:
    """Return the names that conditions speak of: labels, ``clip`` and ``match``."""
    mirrored = ((it.first, it.second) for it in conditions if isinstance(it, clauses.Mirrors))
    return frozenset().union(*mirrored, (it.name for it in nodes_in(tuple(conditions), Reference)))


def extras_in(query: Query) -> frozenset[str]:
    """Return the columns that a search reads besides those that every search does."""
    asked = {it.field for it in nodes_in(query.where, Reference) if it.name != CLIP}
    asked |= {GRADES.get(word.kind, "") for word in nodes_in(query.pattern, Word)}
    asked |= {"swings" for step in nodes_in(query.pattern, Step) if step.manner == STILL}
    return frozenset(asked.intersection(EXTRA))


def value_of(reference: Reference, hit: Hit) -> Value:
    """Return a field of a hit, None where it is missing; times are seconds from its start."""
    if is_of_span(reference):
        return value_of_span(reference, hit.capture, hit.span)
    symbols = hit.lines[0] if reference.name == MATCH else hit.labels.get(reference.name, ())
    if not symbols:
        return None
    if reference.field not in _TIMES:
        return _of_symbol(symbols[-1], reference.field)
    span = Span(min(it.start for it in symbols), max(it.stop for it in symbols))
    return value_of_span(Reference(MATCH, reference.field), hit.capture, span)


def is_of_span(reference: Reference) -> bool:
    """Return whether capture and frames of a hit are all that a field needs."""
    return reference.name == CLIP or (reference.name == MATCH and reference.field in _TIMES)


def value_of_span(reference: Reference, capture: Capture, span: Span) -> Value:
    """Return a field that needs only capture and frames of a hit, see `is_of_span`."""
    field = reference.field
    if reference.name != CLIP:
        frames = {"start": span.start, "end": span.stop, "length": span.stop - span.start}
        return frames[field] / capture.rate
    if field in _CLIP:
        value = _CLIP[field](capture)
        return None if value == "" else value
    # people write the name of a column of theirs in small letters or capitals
    return next((it for name, it in capture.metadata.items() if name.lower() == field), "") or None


def _of_symbol(symbol: Symbol, field: str) -> Value:
    if field in AMOUNTS:
        kind = KINDS[kind_of(symbol.part)]
        if field not in kind.words or symbol.amount is None:
            return None
        if field == "bend":
            return Fraction(degree_of(symbol.amount))
        return kind.amount(symbol.amount) if kind.amounts else Fraction(symbol.amount)
    value = symbol.runner_direction if field == "else" else getattr(symbol, field)
    return Fraction(round(value * 1000), 1000) if isinstance(value, float | int) else value


def order(reference: Reference, value: Value) -> tuple[bool, bool, str | Fraction | int]:
    """Return a key that sorts values of a field: numbers, then texts by letter, then None."""
    if not isinstance(value, str):
        return value is None, False, value or 0
    if reference.name != CLIP and reference.field == "level":
        return False, False, LEVEL_CODES[value]
    digits = value.strip().removeprefix("-").replace(".", "", 1)
    if digits.isascii() and digits.isdecimal() and len(digits) < 100:
        return False, False, Fraction(value.strip())
    return False, True, value


def meets(capture: Capture, condition: clauses.Comparison) -> bool:
    """Return whether a capture meets a condition on it alone."""
    left, right = (_sum(side, capture) for side in (condition.left, condition.right))
    if left is None or right is None:
        return False
    if isinstance(left, Fraction) != isinstance(right, Fraction):
        left, right = number_of(left), number_of(right)
        if left is None or right is None:  # a word is no number
            return condition.compare == "!="
    if left in LEVELS and right in LEVELS:  # by height, not by letter
        left, right = (Fraction(LEVELS.index(str(side))) for side in (left, right))
    return bool(COMPARE[condition.compare](left, right))


def _sum(side: clauses.Sum, capture: Capture) -> Value:
    clock = Clock(capture.rate, capture.meter.speed / 60)
    values = [constant(term, clock, capture) for _, term in side.terms]
    if len(values) == 1:
        return values[0]
    total = Fraction(0)
    for (sign, _), value in zip(side.terms, map(number_of, values), strict=True):
        if value is None:
            return None
        total += sign * value
    return total


def constant(term: clauses.Term, clock: Clock, capture: Capture | None) -> Value:
    """Return the value of a term without a label: a field of the capture, a time, a word."""
    match term:
        case Reference():
            assert capture
            return value_of_span(term, capture, Span(0, 0))
        case Time():
            return term.frames(clock) / clock.rate
    return term.value


def number_of(value: Value) -> Fraction | None:
    """Return a number, also where it is written as text."""
    try:
        return None if value is None else Fraction(value)
    except (ValueError, ZeroDivisionError):
        return None


def about(part: str, amount: Amount) -> Amount:
    """Return amounts as mirror images compare them: turns in eighths, bends of a gesture as 0."""
    kind = KINDS[kind_of(part)]
    if "amount" not in kind.fields:
        return amount * 0
    return amount if kind.amounts else (amount + _EIGHTH // 2) // _EIGHTH
