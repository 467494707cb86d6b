"""What two scores differ in, symbol by symbol.

The symbols of each track are laid beside each other in their order, so that the fewest are left
out, added or replaced (Levenshtein, 1966; by ``rapidfuzz``, a machine word of symbols at a time);
where that can be done in several ways, so that times agree best.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from lanindex.alphabet import KINDS, TRACKS, kind_of
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.model.derived import STEP

SECONDS = 0.1
"""How far apart symbols may begin or end that are at the same time."""

DEGREES = 5
"""By how much turns, twists and inclines may differ that are the same."""


@dataclass(frozen=True, slots=True)
class Timed:
    """A symbol with its times in seconds."""

    symbol: Symbol
    start: float
    stop: float


@dataclass(frozen=True, slots=True)
class Difference:
    """A symbol that is not the same in both scores.

    `seen` is False where one score has nothing because it does not know the part at that time.
    """

    part: str
    one: Timed | None
    other: Timed | None
    seen: bool = True

    @property
    def kind(self) -> str:
        """What is the matter.

        ``left out``, ``added``, ``replaced`` (by something else), ``moved`` in time, or ``not
        seen``: nothing stands where the part was not known.
        """
        if not self.seen:
            return "not seen"
        if self.one is None or self.other is None:
            return "added" if self.one is None else "left out"
        return "moved" if _same(self.one.symbol, self.other.symbol) else "replaced"

    @property
    def later(self) -> float:
        """By how many seconds the other begins later; 0 where there is but one."""
        return self.other.start - self.one.start if self.one and self.other else 0.0

    @property
    def longer(self) -> float:
        """By how many seconds the other lasts longer; 0 where there is but one."""
        if self.one is None or self.other is None:
            return 0.0
        return self.other.stop - self.one.stop - self.later


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two scores beside each other; `only` are the tracks that either has alone."""

    differences: tuple[Difference, ...]
    same: int
    parts: tuple[str, ...]
    only: tuple[tuple[str, ...], tuple[str, ...]]


def compare(
    one: Score, other: Score, *, parts: Sequence[str] | None = None, tolerance: float = SECONDS
) -> Comparison:
    """Return what two scores differ in, in tracks that both have.

    Symbols that begin and end within `tolerance` seconds of each other are at the same time.
    Passing symbols are not compared, nor are steps: supports already say them.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.compare import compare
    >>> three, four = (lanindex.read_lnd(f"corpus/conductor_{it}.lnd") for it in ("three", "four"))
    >>> found = compare(three, four, parts=["r_arm"])
    >>> found.same, found.differences[0].kind
    (1, 'moved')
    """
    if not tolerance >= 0:
        raise UsageError(f"a tolerance of {tolerance:g} s", wanted="0 or more")
    held = [{part for part in score.tracks if len(score.tracks[part])} for score in (one, other)]
    order = [part for part in (*TRACKS, *sorted((held[0] | held[1]) - {*TRACKS})) if part != STEP]
    asked = order if parts is None else parts
    for part in asked:
        if parts is not None and part not in held[0] | held[1]:
            there = " ".join(it for it in order if it in held[0] | held[1])
            raise UsageError(f'there is no part "{part}"', wanted=f"one of {there}")
    both = [
        part
        for part in asked
        if part in one.tracks and part in other.tracks and part in held[0] | held[1]
    ]
    if not both:
        raise UsageError("no track that both have", wanted="one at least")
    found, same = list[Difference](), 0
    for part in both:
        for pair in _beside(_timed(one, part), _timed(other, part)):
            if _differs(pair, tolerance):
                found.append(_looked_at(pair, one, other))
            else:
                same += 1
    only = [tuple(part for part in asked if part in own and part not in both) for own in held]
    return Comparison(tuple(found), same, tuple(both), (only[0], only[1]))


def _timed(score: Score, part: str) -> list[Timed]:
    """Return the symbols of a track that stand in a score."""
    rate = float(score.rate)
    symbols = (symbol for symbol in score.tracks[part].listed() if not symbol.passing)
    return [Timed(symbol, symbol.start / rate, symbol.stop / rate) for symbol in symbols]


def _looked_at(pair: Difference, one: Score, other: Score) -> Difference:
    """Return a difference that says so where a score could not have what the other has."""
    it, score = (pair.one, other) if pair.other is None else (pair.other, one)
    if it is None or (pair.one is not None and pair.other is not None):
        return pair
    known, rate = score.tracks[pair.part].known, float(score.rate)
    at = bisect_right(known, it.start * rate + 1, key=lambda span: span.start) - 1
    return replace(pair, seen=at >= 0 and it.stop * rate - 1 <= known[at].stop)


def _differs(pair: Difference, tolerance: float) -> bool:
    one, other = pair.one, pair.other
    if one is None or other is None or not _same(one.symbol, other.symbol):
        return True
    apart = max(abs(one.start - other.start), abs(one.stop - other.stop))
    return apart > tolerance + 1e-9


def _said(symbol: Symbol) -> str:
    """Return what a symbol says; where it goes somewhere, only where to."""
    if symbol.direction is None and symbol.level is None:
        return symbol.words
    return f"{symbol.direction} {symbol.level}"


def _same(one: Symbol, other: Symbol) -> bool:
    """Return whether two symbols say the same; what only one tells is no difference."""
    if _said(one) != _said(other):
        return False
    if one.amount is None or other.amount is None:
        return True
    kind = KINDS[kind_of(one.part)]
    if kind.amounts:
        return kind.amount(one.amount) == kind.amount(other.amount)
    return abs(one.amount - other.amount) <= DEGREES


def _beside(one: list[Timed], other: list[Timed]) -> Iterator[Difference]:
    """Yield the symbols of a track in pairs, or alone."""
    numbers: dict[str, int] = {}
    codes = [
        [numbers.setdefault(_said(it.symbol), len(numbers)) for it in symbols]
        for symbols in (one, other)
    ]
    pairs = _in_time(_equal(*codes), codes, [one, other])
    first = second = 0
    later = 0.0
    for at, to in pairs:
        yield from _between(one[first:at], other[second:to], later)
        yield Difference(one[at].symbol.part, one[at], other[to])
        first, second, later = at + 1, to + 1, other[to].start - one[at].start
    yield from _between(one[first:], other[second:], later)


Pair = tuple[int, int]
"""Places of two symbols that say the same, in either sequence."""


def _equal(one: list[int], other: list[int]) -> list[Pair]:
    """Return which places of two sequences correspond, where they say the same."""
    from rapidfuzz.distance import Levenshtein

    return [
        (run.src_start + step, run.dest_start + step)
        for run in Levenshtein.opcodes(one, other)
        if run.tag == "equal"
        for step in range(run.src_end - run.src_start)
    ]


def _in_time(pairs: list[Pair], codes: list[list[int]], both: list[list[Timed]]) -> list[Pair]:
    """Return pairs moved to where times agree best: of seven equal jumps any might be left out.

    Each pair may go from its neighbour before to that behind. Once from the last to the first, for
    those that go on, and once back: where one sequence is the other with some left out, no pair is
    apart in time then.
    """
    times = [[(it.start + it.stop) / 2 for it in symbols] for symbols in both]
    for side in (0, 1):
        places: dict[int, list[int]] = {}
        for place, code in enumerate(codes[side]):
            places.setdefault(code, []).append(place)
        own, wanted = times[side], times[1 - side]
        at = [-1, *(pair[side] for pair in pairs), len(own)]
        there = [pair[1 - side] for pair in pairs]
        for number in (*range(len(pairs), 0, -1), *range(1, len(pairs) + 1)):
            same, time = places[codes[side][at[number]]], wanted[there[number - 1]]
            first = bisect_right(same, at[number - 1])
            last = bisect_left(same, at[number + 1]) - 1
            later = bisect_left(same, time, first, last, key=own.__getitem__)
            before = same[max(later - 1, first)]
            nearer = time - own[before] < own[same[later]] - time
            at[number] = before if nearer else same[later]
        pairs = [pair if side == 0 else pair[::-1] for pair in zip(at[1:-1], there, strict=True)]
    return pairs


def _between(one: list[Timed], other: list[Timed], later: float) -> Iterator[Difference]:
    """Yield what stands between two symbols that correspond: in pairs where times overlap."""
    first = second = 0
    while first < len(one) and second < len(other):
        left, right = one[first], other[second]
        begins, ends = right.start - later, right.stop - later
        overlap = min(left.stop, ends) > max(left.start, begins)
        if overlap or abs(left.start - begins) < SECONDS:
            yield Difference(left.symbol.part, left, right)
            first, second = first + 1, second + 1
        elif left.start < begins:
            yield Difference(left.symbol.part, left, None)
            first += 1
        else:
            yield Difference(right.symbol.part, None, right)
            second += 1
    for it in one[first:]:
        yield Difference(it.symbol.part, it, None)
    for it in other[second:]:
        yield Difference(it.symbol.part, None, it)
