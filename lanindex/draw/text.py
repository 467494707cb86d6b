"""A staff in plain text: time runs down, as text does, a row a fraction of a second.

A score is read upwards; a terminal is read from the top, in a pager and behind ``head``, too. Sides
are as in a score, own left on the left. A symbol is a sign where it begins, and a bar behind it for
as long as it lasts.
"""

from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, zip_longest
from math import inf
from textwrap import wrap

import numpy as np

from lanindex.alphabet import BENT, KINDS, Kind, group_of, kind_of
from lanindex.data import shipped
from lanindex.draw.staff import STANCES, Key, keys_of, name_of, staff_columns, usual_tracks
from lanindex.errors import UsageError
from lanindex.model import Score, Span, Symbol
from lanindex.model.derived import degree_of
from lanindex.model.score import rows_of

_TABLE = shipped("draw/text.toml")


@dataclass(frozen=True, slots=True)
class Signs:
    """The characters of a staff."""

    directions: tuple[str, ...]  # By a direction's code; what turns has others
    turns: tuple[str, ...]
    levels: tuple[str, ...]  # By a level's code, and last where there is none
    bars: tuple[str, ...]
    bends: tuple[str, str]  # Bent, straight
    cell: int  # How many there are in a column, behind one for the mark
    # Before what is marked; the staff's lines, upright, across, and where it begins and ends; rows
    # that say nothing new; a foot that stands
    mark: str
    line: str
    rule: str
    double: str
    fold: str
    hold: str

    @property
    def legend(self) -> str:
        """What the signs mean, in a line."""
        (right, _, forward, *_, place), (low, mid, high, _) = self.directions, self.levels
        bent, straight = self.bends
        return (
            f"time runs down; {forward} forward, {right} right, {place} place, {high} high,"
            f" {mid} mid, {low} low; {bent} bent, {straight} straight; a number: sixths"
            f" of a bend, or degrees; {self.mark} matched, {self.hold} stands, ? not known"
        )

    def of(self, kind: Kind, direction: int, level: int, amount: int) -> str:
        """Return the characters of a symbol from its codes; less than 0 is nothing."""
        directions = self.turns if kind.name in ("turn", "twist") else self.directions
        text = directions[direction] if direction >= 0 else ""
        text += self.levels[level] if level >= 0 else ""
        if amount < 0:
            pass
        elif kind.name == "bend":
            degree = degree_of(amount)
            text += f"{self.bends[not degree]}{degree or ''}"
        elif kind.name == "gesture":
            text += str(amount) if amount >= BENT else ""
        elif kind.amounts:
            text += kind.amount(amount)
        else:
            text += str(amount or "") if amount < 1000 else f"{amount // 360}x"
        return text[: self.cell]


UNICODE, ASCII = (Signs(**_TABLE[it]) for it in ("unicode", "ascii"))


def names_of(parts: Iterable[str]) -> Iterator[list[str]]:
    """Yield the lines of names above columns, word by word."""
    words = []
    for part in parts:
        side = part[0].upper() if part[:2] in ("r_", "l_") else ""
        own = " ".join(_TABLE["shorter"].get(word, word) for word in name_of(part).split())
        words.append([side, *own.split()])
    yield from (list(row) for row in zip_longest(*words, fillvalue=""))


StyledLine = tuple[tuple[str, str], ...]
"""Some text, piece by piece, each with its style: ``match``, ``dim``, ``place`` or none."""

_SHORT = Fraction(4)
# Seconds of a row, and how many rows lie between times: for short stretches, for others
_STEPS = (Fraction(1, 10), 5), (Fraction(1, 4), 4)
_FOLDED = 3  # rows, at most, that say nothing new; more of them are one
_LINES = 3  # characters of the staff's lines
_WITHIN = 1 << 20  # sub-rows of a row, for several symbols that begin in it


@dataclass(frozen=True, slots=True)
class _Drawn:
    """A symbol in rows of text."""

    sign: str
    bar: str  # What stands in the rows behind the sign
    marked: bool
    key: int  # The row in which it begins, times `_WITHIN`
    end: int  # The last row that it reaches


@dataclass(frozen=True, slots=True)
class _Column:
    """What a track does between two frames."""

    part: str  # Whose
    symbols: list[_Drawn]
    first: tuple[str, bool] | None  # The sign in force at the beginning, and whether it is marked
    # Rows in which the part begins to be seen, ceases to be seen ..., and the foot to stand
    known: list[int]
    stands: list[int]

    def events(self) -> list[int]:
        """Return the keys of rows that say something new."""
        rows = (*(it.end + 1 for it in self.symbols), *self.known, *self.stands)
        return [*(it.key for it in self.symbols), *(row * _WITHIN for row in rows)]

    def cell(self, key: int, hold: str) -> tuple[str, bool]:
        """Return the text of a row, and whether it is marked."""
        at, row = bisect_right(self.symbols, key, key=lambda it: it.key) - 1, key // _WITHIN
        symbol = self.symbols[at] if at >= 0 else None
        if symbol and (row <= symbol.end or symbol.key == key):
            return (symbol.sign if symbol.key == key else symbol.bar), symbol.marked
        if bisect_right(self.stands, row) % 2:
            return hold, False
        return "" if bisect_right(self.known, row) % 2 else "?", False


class TextStaff:
    """A score that can be shown as text, whole or in stretches."""

    def __init__(self, score: Score, signs: Signs = UNICODE) -> None:
        self.score, self.signs = score, signs
        every = {part: rows_of(score, part) for part in score.tracks}
        self._rows = {part: rows for part, rows in every.items() if len(rows)}

    def lines(
        self,
        start: int = 0,
        stop: int | None = None,
        *,
        parts: Sequence[str] | None = None,
        marked: Iterable[Symbol] = (),
        width: int | None = None,
    ) -> Iterator[StyledLine]:
        """Yield the lines of a staff."""
        last = self.score.frames if stop is None else min(stop, self.score.frames)
        if not self._rows:
            raise UsageError("an empty score", wanted="a symbol in it")
        if not 0 <= start < last:
            found, wanted = f"nothing from frame {start} to {last}", f"0 to {self.score.frames}"
            raise UsageError(found, wanted=f"a stretch of {wanted}")
        for part in parts or ():
            if part not in self._rows:
                wanted = f"one of {' '.join(self._rows)}"
                raise UsageError(f'there is no part "{part}"', wanted=wanted)
        return self._lines(Span(start, last), parts, keys_of(self.score, marked), width)

    def _lines(
        self, span: Span, parts: Sequence[str] | None, marked: frozenset[Key], width: int | None
    ) -> Iterator[StyledLine]:
        rate, signs = self.score.rate, self.signs
        step, every = _STEPS[len(span) / rate > _SHORT]
        scale, meant = rate * step, {part for part, *_ in marked}
        wanted = {*(parts or meant | ({*usual_tracks(self._rows)} - STANCES) or self._rows)}
        drawn = [self._column(part, span, scale, marked) for part in self._rows if part in wanted]
        moving = [it for it in drawn if parts or it.symbols or it.part in meant] or drawn
        still = [it for it in drawn if it not in moving]
        label = max(5, len(f"{float(span.stop / rate):.2f}"))
        blank, wide = " " * label, signs.cell + 1
        most = len(moving) if width is None else max((width - label - 1 - _LINES) // wide, 1)
        shown, left_out = _fitting(moving, meant, most)
        lines = _across(shown, signs.line)
        across = len("".join(lines)) + wide * len(shown)
        for names in names_of([it.part for it in shown]):
            yield _line(blank, [(name, False) for name in names], lines, wide)
        if any(it.first for it in shown):
            cells = [it.first or ("", False) for it in shown]
            yield _line(blank, cells, lines, wide, signs.mark)
        yield ((f"{blank} {(signs.rule if span.start else signs.double) * across}", "dim"),)
        first, last = _row(span.start, scale), _row(span.stop - 1, scale)
        events = {key for it in shown for key in it.events() if first <= key // _WITHIN <= last}
        events |= {first * _WITHIN}
        labelled = True
        for key, after in pairwise([*sorted(events), (last + 1) * _WITHIN]):
            row, end = key // _WITHIN + 1, after // _WITHIN
            folded = end - row > _FOLDED  # one row for those that say nothing new
            behind = range(row, row + 1 if folded else end)
            for one, fold in [(key, False), *((it * _WITHIN, folded) for it in behind)]:
                row, within = divmod(one, _WITHIN)
                text = signs.fold if fold else f"{float(max(row * step, span.start / rate)):.2f}"
                text = text if fold or labelled or row % every == within == 0 else ""
                labelled = fold
                cells = [it.cell(one, signs.hold) for it in shown]
                yield _line(text.rjust(label), cells, lines, wide, signs.mark)
        ended = span.stop == self.score.frames
        yield ((f"{blank} {(signs.double if ended else signs.rule) * across}", "dim"),)
        quiet = ", ".join(f"{it.part} {it.first[0]}" for it in still if it.first)
        others = ", ".join(it.part for it in left_out)
        for title, those in (("still: ", quiet), ("no room for ", others)):
            for text in wrap(title + those, width or 10**9) if those else ():
                yield ((text, "dim"),)

    def _column(self, part: str, span: Span, scale: Fraction, marked: frozenset[Key]) -> _Column:
        """Return what a track does between two frames; `scale` is the frames of a row."""
        kind, rows = KINDS[kind_of(part)], self._rows[part]
        first, last = self._within(part, span)
        spans = self.score.tracks[part].known
        known = [it for it in spans if it.start < span.stop and span.start < it.stop]
        in_force = first and kind.lasts and known and rows["start"][first - 1] >= known[0].start
        symbols, before = list[_Drawn](), None
        names = ["direction", "level", "amount", "start", "stop"]
        fields = rows[names][first - bool(in_force) : last].tolist()
        for number, (direction, level, amount, start, stop) in enumerate(fields):
            sign, lit = self.signs.of(kind, direction, level, amount), (part, start, stop) in marked
            if in_force and number == 0:
                before = sign, lit
                continue
            row = _row(max(start, span.start), scale)
            key = max([row * _WITHIN, *(it.key + 1 for it in symbols[-1:])])
            end = _row(min(stop, span.stop) - 1, scale) if start < stop else row - 1
            symbols.append(_Drawn(sign, self.signs.bars[level], lit, key, end))
        stances, stance = list[Span](), f"{part[:2]}stance"
        if kind.name == "support" and stance in self._rows:  # the foot stands
            some = self._rows[stance][slice(*self._within(stance, span))]
            stances = [Span(*it) for it in some[["start", "stop"]].tolist()]
        return _Column(part, symbols, before, _toggles(known, scale), _toggles(stances, scale))

    def _within(self, part: str, span: Span) -> tuple[int, int]:
        """Return which rows of a track lie between two frames, but those that end there."""
        rows = self._rows[part]
        ends = np.searchsorted(rows["stop"], span.start, "right")
        return int(ends), int(np.searchsorted(rows["start"], span.stop))


def _row(frame: int, scale: Fraction) -> int:
    return frame * scale.denominator // scale.numerator


def _toggles(spans: Iterable[Span], scale: Fraction) -> list[int]:
    """Return the rows in which spans begin, end, begin ..., in order."""
    found: list[int] = []
    for span in spans:
        if span.stop > span.start:
            found.append(max([_row(span.start, scale), *found[-1:]]))
            found.append(_row(span.stop - 1, scale) + 1)
    return found


def _fitting(
    drawn: Sequence[_Column], wanted: Collection[str], most: int
) -> tuple[list[_Column], list[_Column]]:
    """Return the columns that are shown, from left to right, and those that have no room."""
    rank = {name: at for at, name in enumerate(_TABLE["columns"]["first"])}

    def importance(column: _Column) -> tuple[bool, int]:
        return column.part not in wanted, rank.get(group_of(column.part), len(rank))

    ordered = sorted(drawn, key=importance)
    kept = {it.part for it in ordered[:most]}
    places = staff_columns(kept).places
    shown = [it for it in drawn if it.part in kept]
    shown.sort(key=lambda it: places.get(it.part, -inf if it.part.startswith("l_") else inf))
    return shown, ordered[most:]


def _across(shown: Sequence[_Column], line: str) -> list[str]:
    """Return the text before each column: a line of the staff or nothing."""
    layout = staff_columns([it.part for it in shown])
    at = [layout.places.get(it.part, layout.right * (-1) ** (it.part[0] == "l")) for it in shown]
    zones = [bisect_right([-layout.inner, 0, layout.inner], x) for x in at]
    return ["", *(line * (zone != after) for zone, after in pairwise(zones))]


def _line(
    label: str, cells: Sequence[tuple[str, bool]], lines: Sequence[str], wide: int, mark: str = " "
) -> StyledLine:
    """Return a line from its cells, marked or not, and the lines of the staff."""
    pieces: list[tuple[str, str]] = [(f"{label} ", "place")]
    for (text, marked), line in zip(cells, lines, strict=True):
        pieces.append((line, "dim"))
        own = (mark if marked else " ") + text
        pieces.append((own.ljust(wide), "match" if marked else ""))
    while not pieces[-1][0].strip() and len(pieces) > 1:
        pieces.pop()
    return (*pieces[:-1], (pieces[-1][0].rstrip(), pieces[-1][1]))
