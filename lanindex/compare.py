"""Compare two scores, symbol by symbol.

The symbols of each track are aligned in order, with as few as possible left out, added or replaced
(Levenshtein, 1966; by ``rapidfuzz``, a machine word of symbols at a time). Of several such
alignments, the one whose times agree best is taken.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from lanindex.alphabet import KINDS, TRACKS, kind_of
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.model.derived import STEP

SECONDS = 0.1  # how far apart the edges of symbols at the same time may lie
Pair = tuple[int, int]  # indices of two equal symbols, one in each sequence
DEGREES = 5  # by how much equal turns, twists and inclines may differ


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
        """``left out``, ``added``, ``replaced``, ``moved`` in time, or ``not seen``."""
        if not self.seen:
            return "not seen"
        if self.one is None or self.other is None:
            return "added" if self.one is None else "left out"
        return "moved" if _mean_the_same(self.one.symbol, self.other.symbol) else "replaced"

    @property
    def later(self) -> float:
        """Seconds by which the other begins later; 0 if there is only one."""
        return self.other.start - self.one.start if self.one and self.other else 0.0

    @property
    def longer(self) -> float:
        """Seconds by which the other lasts longer; 0 if there is only one."""
        return self.other.stop - self.one.stop - self.later if self.one and self.other else 0.0

    @property
    def change(self) -> str:
        """What the other is, compared with the one: ``added``, ``0.20 s later, 0.10 s shorter``."""
        if self.kind != "moved":
            return self.kind
        changes = ((self.later, "earlier", "later"), (self.longer, "shorter", "longer"))
        return ", ".join(
            f"{abs(seconds):.2f} s {more if seconds > 0 else less}"
            for seconds, less, more in ((round(it, 2), less, more) for it, less, more in changes)
            if seconds
        )


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
    """Return the differences of two scores, in tracks that both have.

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
    either = held[0] | held[1]
    order = [part for part in (*TRACKS, *sorted(either - {*TRACKS})) if part != STEP]
    for part in parts or ():
        if part not in either:
            known = " ".join(it for it in order if it in either)
            raise UsageError(f'there is no part "{part}"', wanted=f"one of {known}")
    chosen = [part for part in (order if parts is None else parts) if part in either]
    both = [part for part in chosen if part in one.tracks and part in other.tracks]
    if not both:
        raise UsageError("no track that both have", wanted="one at least")
    differences, same = list[Difference](), 0
    for part in both:
        for pair in _aligned(_timed(one, part), _timed(other, part)):
            if _is_different(pair, tolerance):
                differences.append(_with_seen(pair, one, other))
            else:
                same += 1
    only = [tuple(it for it in chosen if it in tracks and it not in both) for tracks in held]
    return Comparison(tuple(differences), same, tuple(both), (only[0], only[1]))


def _timed(score: Score, part: str) -> list[Timed]:
    """Return the symbols of a track that stand in a score."""
    rate = float(score.rate)
    symbols = (symbol for symbol in score.tracks[part].listed() if not symbol.passing)
    return [Timed(symbol, symbol.start / rate, symbol.stop / rate) for symbol in symbols]


def _with_seen(pair: Difference, one: Score, other: Score) -> Difference:
    """Return a difference with `seen` False where the other score does not know the part."""
    it, score = (pair.one, other) if pair.other is None else (pair.other, one)
    if it is None or (pair.one is not None and pair.other is not None):
        return pair
    known, rate = score.tracks[pair.part].known, float(score.rate)
    at = bisect_right(known, it.start * rate + 1, key=lambda span: span.start) - 1
    return replace(pair, seen=at >= 0 and it.stop * rate - 1 <= known[at].stop)


def _is_different(pair: Difference, tolerance: float) -> bool:
    one, other = pair.one, pair.other
    if one is None or other is None or not _mean_the_same(one.symbol, other.symbol):
        return True
    apart = max(abs(one.start - other.start), abs(one.stop - other.stop))
    return apart > tolerance + 1e-9


def _meaning(symbol: Symbol) -> str:
    """Return a symbol's words; of a direction symbol, direction and level only."""
    if symbol.direction is None and symbol.level is None:
        return symbol.words
    return f"{symbol.direction} {symbol.level}"


def _mean_the_same(one: Symbol, other: Symbol) -> bool:
    """Return whether two symbols mean the same; an amount that only one has is no difference."""
    if _meaning(one) != _meaning(other):
        return False
    if one.amount is None or other.amount is None:
        return True
    kind = KINDS[kind_of(one.part)]
    if kind.amounts:
        return kind.amount(one.amount) == kind.amount(other.amount)
    return abs(one.amount - other.amount) <= DEGREES


def _aligned(one: list[Timed], other: list[Timed]) -> Iterator[Difference]:
    """Yield the symbols of a track in pairs, or alone."""
    from rapidfuzz.distance import Levenshtein

    numbers: dict[str, int] = {}
    codes = [
        [numbers.setdefault(_meaning(it.symbol), len(numbers)) for it in symbols]
        for symbols in (one, other)
    ]
    equal = [
        (run.src_start + step, run.dest_start + step)
        for run in Levenshtein.opcodes(*codes)
        if run.tag == "equal"  # in the shortest edit
        for step in range(run.src_end - run.src_start)
    ]
    pairs = _pairs_aligned_in_time(equal, codes, [one, other])
    first = second = 0
    later = 0.0
    for at, to in pairs:
        yield from _between(one[first:at], other[second:to], later)
        yield Difference(one[at].symbol.part, one[at], other[to])
        first, second, later = at + 1, to + 1, other[to].start - one[at].start
    yield from _between(one[first:], other[second:], later)


def _pairs_aligned_in_time(
    pairs: list[Pair], codes: list[list[int]], tracks: list[list[Timed]]
) -> list[Pair]:
    """Return pairs moved to where times agree best: any of seven equal jumps may be missing.

    Each pair may move between its neighbours. One pass runs from the last pair to the first, one
    back; if one sequence is the other with some left out, all pairs then agree in time.
    """
    times = [[(it.start + it.stop) / 2 for it in symbols] for symbols in tracks]
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
    """Yield the symbols between two aligned pairs: as pairs where their times overlap."""
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
    yield from (Difference(it.symbol.part, it, None) for it in one[first:])
    yield from (Difference(it.symbol.part, None, it) for it in other[second:])
