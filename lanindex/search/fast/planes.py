"""One part's rows as planes: for each kind of cell a bit a symbol, 64 of them in a word.

Steps that follow each other are then a few operations on words: the plane of the first, and that
of the second moved by one symbol, and so on. A bit stands for a symbol that the score shows, told
by its rank among these; passing symbols are few, and looked at one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import PASSING, STARTING, THOUSANDTHS, Columns, begins_of
from lanindex.search.fast.ragged import Mask, Numbers, Whole
from lanindex.search.language.words import WORD_KINDS

WORD = 64
"""Bits of a word."""

SPANS_KEPT = 8
"""For how many symbols in a row it is kept where a stretch goes on: a bit a symbol for each."""

CELLS = ("direction", "level")
"""Kinds of words of which a symbol's own cell tells."""

Plane = NDArray[np.uint64]
"""(words + 1,): bit r of it, the lowest of a word first, tells of place r; the last word is 0."""

Planes = NDArray[np.uint64]

Bytes = NDArray[np.uint8]

_ORDER = np.dtype("<u8")
_BELOW = ((1 << np.arange(8)) - 1).astype(np.uint8)
_COUNTS = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1).sum(1).astype(np.uint8)


def packed(mask: Mask) -> Plane:
    """Return a mask as a plane."""
    bits = np.packbits(mask, bitorder="little")
    plane = np.zeros(len(mask) // WORD + 2, _ORDER)
    plane.view(np.uint8)[: len(bits)] = bits
    return plane


def ahead(plane: Plane, steps: int) -> Plane:
    """Return the plane that tells of each place what another one tells of some places later."""
    words, bits = divmod(steps, WORD)
    moved = np.zeros_like(plane)
    if words < len(plane):
        moved[: len(plane) - words] = plane[words:]
    if bits:
        over = moved[1:] << np.uint64(WORD - bits)
        moved >>= np.uint64(bits)
        moved[:-1] |= over
    return moved


def places(plane: Plane) -> Whole:
    """Return the places that a plane holds."""
    words = np.flatnonzero(plane)
    if 2 * len(words) > len(plane):
        return np.flatnonzero(np.unpackbits(plane.view(np.uint8), bitorder="little").view(bool))
    bits = np.unpackbits(plane[words].view(np.uint8), bitorder="little")
    found = np.flatnonzero(bits.view(bool))
    first: Whole = (words * WORD)[found >> 6]
    first += found & (WORD - 1)
    return first


def holds(plane: Plane, where: Whole) -> Mask:
    """Tell which places a plane holds."""
    bits: Bytes = plane.view(np.uint8)[where >> 3] >> (where & 7).astype(np.uint8) & 1
    return bits.view(np.bool_)


class Counted:
    """A plane, and how many places it holds before each.

    Parameters
    ----------
    plane : ndarray
        As from `packed`.
    """

    def __init__(self, plane: Plane) -> None:
        self.plane = plane
        counts = _COUNTS[plane.view(np.uint8)]
        self._before = np.zeros(len(counts) + 1, np.int32)
        np.cumsum(counts, out=self._before[1:])

    def before(self, where: Whole) -> Whole:
        """Return how many places are held before each."""
        byte = where >> 3
        here = _COUNTS[self.plane.view(np.uint8)[byte] & _BELOW[where & 7]]
        before: Whole = self._before[byte].astype(np.int64)
        before += here
        return before


class Part:
    """One part's rows in all captures, and what was worked out about them.

    Parameters
    ----------
    columns : Columns
        Of the part. Their arrays are held, not they themselves: they hold this.
    """

    def __init__(self, columns: Columns) -> None:
        self.cell, self.bounds = columns.cell, columns.bounds
        self.margin, self.start, self.stop = columns.margin, columns.start, columns.stop
        self.part, self.gaps = columns.part, columns.gaps
        self._spans: list[Plane] = []
        self._known: set[int] = set()

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(self.cell)

    @cached_property
    def begins(self) -> Mask:
        """Which rows begin a stretch, (S + 1,); the one behind the last does."""
        return begins_of(self.part, self.cell, self.bounds, self.start, self.gaps)

    @cached_property
    def stretches(self) -> Counted:
        """The same as bits, to be counted."""
        return Counted(packed(self.begins))

    @cached_property
    def beginnings(self) -> Numbers:
        """The first row of each stretch, and the one behind the last."""
        return np.flatnonzero(self.begins)

    def behind(self, rows: Whole) -> Whole:
        """Return the row behind the last one of the stretch of each."""
        found: Whole = self.beginnings[self.stretches.before(rows + 1)]
        return found

    @cached_property
    def passed(self) -> Whole:
        """The passing rows."""
        return np.flatnonzero(self.cell & PASSING)

    @cached_property
    def shown(self) -> Numbers | None:
        """The rows that the score shows, int32; None: all of them."""
        if not len(self.passed):
            return None
        return np.flatnonzero(self.cell & PASSING == 0).astype(np.int32)

    @cached_property
    def seen(self) -> Bytes:
        """The cells of these rows."""
        return self.cell if self.shown is None else self.cell[self.shown]

    @cached_property
    def _hidden(self) -> Counted:
        mask = np.zeros(len(self) + 1, bool)
        mask[self.passed] = True
        return Counted(packed(mask))

    def ranks(self, rows: Whole) -> Whole:
        """Return how many rows the score shows before each of some."""
        return rows if self.shown is None else rows - self._hidden.before(rows)

    def rows(self, ranks: Whole) -> Whole:
        """Return the rows that the score shows, by their ranks."""
        return ranks if self.shown is None else self.shown[ranks].astype(np.int64)

    @cached_property
    def filled(self) -> tuple[Whole, Whole]:
        """The captures that have rows, and the first row of each; and that behind the last."""
        captures = np.flatnonzero(np.diff(self.bounds))
        return captures, np.append(self.bounds[captures], len(self))

    @cached_property
    def near(self) -> Numbers:
        """In which of these captures the first row of each word of rows is, int32."""
        first = np.arange(0, len(self), WORD)
        return (np.searchsorted(self.filled[1], first, "right") - 1).astype(np.int32)

    @cached_property
    def entered(self) -> Counted:
        """The rows that are the first of a capture, and the one behind the last, to be counted."""
        mask = np.zeros(len(self) + 1, bool)
        mask[self.filled[1]] = True
        return Counted(packed(mask))

    def captures(self, rows: Whole) -> Whole:
        """Return in which captures rows are."""
        found: Whole = self.filled[0][self.entered.before(rows + 1) - 1]
        return found

    @cached_property
    def store(self) -> Planes:
        """The planes that patterns are made of, (planes, words + 1); filled as they are needed."""
        return np.zeros((len(_STORED), len(self.seen) // WORD + 2), _ORDER)

    def place(self, kind: str, code: int) -> int:
        """Return which plane of the store tells of which shown rows a code is true."""
        place = _STORED[kind, code]
        if place not in self._known:
            self._known.add(place)
            self.store[place] = packed(_TELLING[kind](self, code))
        return place

    def together(self, steps: int) -> Plane:
        """Return the plane of the ranks whose stretch goes on for so many more."""
        spans = self._spans or [packed(np.ones(len(self.seen), bool))]
        self._spans, goes_on = spans, self.store[self.place(*GOES_ON)]
        while len(spans) <= min(steps, SPANS_KEPT):
            spans.append(spans[-1] & ahead(goes_on, len(spans) - 1))
        plane = spans[min(steps, SPANS_KEPT)]
        for more in range(SPANS_KEPT, steps):
            plane = plane & ahead(goes_on, more)
        return plane

    def goes_on(self) -> Mask:
        """Tell which shown rows are followed by another one of their stretch."""
        follows = np.zeros(len(self.seen), bool)
        if self.shown is None:
            follows[:-1] = ~self.begins[1:-1]
        else:
            stretch = np.cumsum(self.begins[:-1], dtype=np.int32)[self.shown]
            follows[:-1] = stretch[1:] == stretch[:-1]
        return follows

    def saying(self, kind: str, codes: frozenset[int]) -> Plane:
        """Return the plane of the shown rows of which one of some codes is true."""
        every = range(-1, len(WORD_KINDS[kind].codes))
        wanted = [code for code in every if code in codes]
        others = [code for code in every if code not in codes]
        fewer = min(wanted, others, key=len)
        if wanted and fewer is wanted:
            return reduce(np.bitwise_or, [self.store[self.place(kind, code)] for code in wanted])
        found = self.together(0).copy()
        for code in others:
            found &= ~self.store[self.place(kind, code)]
        return found

    def after(self, rows: Whole, passing: bool) -> tuple[Whole, Whole]:
        """Return where ``->`` leads from some rows, passing ones too if they are wanted.

        Returns
        -------
        ndarray, ndarray
            Places in `rows`, and rows.
        """
        there = rows + 1
        going = ~self.begins[there]
        sources, there = np.flatnonzero(going), there[going]
        found = [(sources[:0], there[:0])]
        while len(there):
            passed = self.cell[there] & PASSING > 0
            kept = slice(None) if passing else ~passed
            found.append((sources[kept], there[kept]))
            going = passed & ~self.begins[there + 1]
            sources, there = sources[going], there[going] + 1
        return np.concatenate([it for it, _ in found]), np.concatenate([it for _, it in found])

    def shown_as(
        self, fits: Mapping[str, frozenset[int]], kinds: Collection[str] = tuple(WORD_KINDS)
    ) -> Plane:
        """Return the plane of the shown rows that words of some kinds fit."""
        planes = [self.saying(kind, codes) for kind, codes in fits.items() if kind in kinds]
        return reduce(np.bitwise_and, planes) if planes else self.together(0)

    def change(self, code: int) -> Mask:
        """Tell which shown rows' level compares with that before as a code says, -1: not at all."""
        level = self.seen >> 4 & 3
        told = level > 0
        if code < 0:
            return ~told
        goes_on = np.unpackbits(self.together(1).view(np.uint8), bitorder="little")[: len(level)]
        both = goes_on[:-1].view(bool) & told[1:] & told[:-1]
        change: Mask = np.zeros(len(level), bool)
        if code == _CHANGES["rising"]:
            change[1:] = both & (level[1:] > level[:-1])
        elif code == _CHANGES["sinking"]:
            change[1:] = both & (level[1:] < level[:-1])
        else:
            change[1:] = both & (level[1:] != level[:-1])
            change = told & ~change
        return change

    def cost(self, rows: Whole) -> Whole:
        """Return what is missing to a margin of 1, in thousandths."""
        return THOUSANDTHS - self.margin[rows].astype(np.int64)


_CHANGES = WORD_KINDS["change"].codes

MOVES, GOES_ON = ("moves", 1), ("goes on", 1)
"""Planes of the movements, without starting positions; of what another follows in its stretch."""

_TELLING: dict[str, Callable[[Part, int], Mask]] = {
    "direction": lambda part, code: (part.seen & 15) == code + 1,
    "level": lambda part, code: (part.seen >> 4 & 3) == code + 1,
    "change": lambda part, code: part.change(code),
    "moves": lambda part, _: part.seen < STARTING,
    "goes on": lambda part, _: part.goes_on(),
}
"""How it is found out of which rows that the score shows a code is true."""

_STORED = {
    key: place
    for place, key in enumerate(
        [
            *(
                (kind, code)
                for kind in (*CELLS, "change")
                for code in range(-1, len(WORD_KINDS[kind].codes))
            ),
            MOVES,
            GOES_ON,
        ]
    )
}
"""Where in the store each plane has its place."""


def part_of(columns: Columns) -> Part:
    """Return what is known of a part's rows; it is kept with the columns, and goes with them.

    All that is ever kept is some 12 bytes a symbol, about what the columns take themselves: 4 for
    the rows that are shown and 1 for their cells (where any is passing), 1 and 3 times 5/8 for
    where stretches and captures begin, 4 for the stretches, 3 for planes.
    """
    found = columns.kept.get(_KEPT)
    if found is None:
        found = columns.kept[_KEPT] = Part(columns)
    assert isinstance(found, Part)
    return found


_KEPT = "lanindex.search.fast.planes"
