"""Pages that were read, as a score: columns become parts, heights become counts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, KINDS, LEVEL_CODES, kind_of
from lanindex.errors import CaptureError
from lanindex.model import SYMBOL, Meter, Score, Span, Track
from lanindex.model.derived import with_steps
from lanindex.model.symbol import blank
from lanindex.reader.beside import missing_staves, strange, unknown_names
from lanindex.reader.boxes import Box, box_at, box_of
from lanindex.reader.layout import Layout, layout
from lanindex.reader.signs import Sign, read
from lanindex.reader.staff import Staff, staves
from lanindex.reader.templates import Name
from lanindex.reader.weight import CIRCLES, jumped, stances

GRID = 4
"""Steps of a count to which times are rounded."""

DOUBTFUL = 0.75
"""Confidence below which a sign is doubtful."""

_REPEAT = "again"
"""The kind of a sign that says that what is before it goes on."""


@dataclass(frozen=True, slots=True)
class Record:
    """A sign that was read; one that is not known has no kind."""

    staff: int  # On which it begins, from the left
    part: str  # Of its column; empty where no column is
    kind: str  # Of `lanindex.alphabet.KINDS`
    direction: str | None
    level: str | None
    amount: int | None  # As of `lanindex.model.Symbol`; None: nothing is written
    start: float  # Counts from the beginning of the page
    end: float  # A starting position begins and ends at 0
    confidence: float
    box: Box  # On the page, pixels

    @property
    def words(self) -> list[str | None]:
        """What it says, in order, as the fields of its line in LND."""
        if not self.part:
            return []
        if self.kind == _REPEAT:
            return ["repeat"]
        kind = KINDS[kind_of(self.part)]
        amount = kind.amounts[self.amount or 0] if kind.amounts else str(self.amount)
        said = {"direction": self.direction, "level": self.level, "amount": amount}
        return [said[it] for it in kind.fields]

    def later(self, counts: float) -> Record:
        """Return it so many counts later."""
        return replace(self, start=self.start + counts, end=self.end + counts)

    @property
    def place(self) -> str:
        """Where it stands, in words."""
        where = self.part or "where no column has a name"
        return f"staff {self.staff + 1}, {where}, count {self.start:g} to {self.end:g}"


@dataclass(frozen=True, slots=True)
class Read:
    """A page that was read."""

    records: list[Record]
    unknown: list[Record]
    beats: int  # Counts in a bar
    counts: int  # On the page
    notes: list[str]  # What else is not known or not sure: names of columns, staves


def read_page(image: NDArray[np.uint8]) -> list[Record]:
    """Return the signs of a page, (H, W) grey, that are known."""
    return read_signs(image).records


def read_signs(image: NDArray[np.uint8]) -> Read:
    """Return the signs of a page, (H, W) grey, known and unknown."""
    found = staves(image)
    page = layout(found)
    signs = sorted(read(page), key=lambda it: it.start)
    records, ends = list[Record](), dict[str, float]()
    for sign in signs:
        one = _record(found, page, sign, ends.get(sign.column.part, 0.0))
        ends[one.part] = one.end
        records.append(one)
    circles = [it for it in records if it.kind in CIRCLES]
    known = [it for it in records if it.kind and it.kind not in CIRCLES]
    unknown = [it for it in records if not it.kind]
    spots = [
        it.start
        for it, sign in zip(records, signs, strict=True)
        if it.kind == "turn" and not sign.column.x
    ]
    known += stances(circles, known, spots, round(page.counts[-1]))
    known = [jumped(it, known) if it.kind == "jump" else it for it in known]
    idle = [it for it in known if it.kind == _REPEAT and not _before(it, known)]
    known = [it for it in known if it not in idle]
    unknown += [replace(it, kind="") for it in idle]  # nothing is before that they could repeat
    for xs, counts in strange(found, page, signs):
        start, end = (max(round(it * GRID) / GRID, 0.0) for it in counts)
        staff = sum(it <= start for it in page.counts[1:-1])
        box = box_at(found, page, xs, counts)
        unknown.append(Record(staff, "", "", None, None, None, start, end, 0.0, box))
    notes = [*missing_staves(found, page), *unknown_names(found, page)]
    if not page.named:
        parts = " ".join(dict.fromkeys(it.part for it in records))
        notes.append(f"no names of columns, taken by their places for {parts}")
    return Read(known, unknown, _beats(found, page), round(page.counts[-1]), notes)


def _record(found: Sequence[Staff], page: Layout, sign: Sign, before: float) -> Record:
    """Return what a sign says, its times rounded; `before` it in its column another one ends."""
    what, part = sign.name or Name(""), sign.column.part
    kind = KINDS[kind_of(part)]
    below = sign.start < -0.5 / GRID
    start, end = (0.0 if below else round(it * GRID) / GRID for it in (sign.start, sign.end))
    staff = sum(it <= start for it in page.counts[1:-1])
    box = box_of(found, page, sign)
    if kind.name in ("jump", "touch"):  # a bow has no length, and a flight may have little
        end = max(end, start + 1 / GRID)
    elif start == end > before:  # one that is shorter than the grid ends where it should
        start -= 1 / GRID
    if "amount" in kind.fields and (what.direction == "place" or kind.name == "travel"):
        what = what._replace(amount=0)  # no degrees are written in it
    # one whose degrees cannot be read has no line in LND
    whole = None not in [getattr(what, it) for it in kind.fields]
    own = what.kind if what.kind in (*CIRCLES, _REPEAT) else kind.name if whole else ""
    name = own if below or start < end or own in CIRCLES else ""
    return Record(staff, part, name, *what[1:], start, end, sign.confidence, box)


def _before(repeat: Record, records: Sequence[Record]) -> list[Record]:
    """Return what a sign repeats: the movement before it, or the two that follow each other.

    If there is none, it is the starting position.
    """
    own = [it for it in records if it.part == repeat.part and it.kind != _REPEAT]
    own = sorted((it for it in own if it.end <= repeat.start), key=lambda it: it.end)
    moves = [it for it in own if it.start < it.end][-2:]
    flush = len(moves) == 2 and moves[0].end == moves[1].start
    return moves if flush else moves[-1:] or own[-1:]


def _written_out(repeat: Record, records: Sequence[Record]) -> Iterator[Record]:
    """Yield the movements that a sign repeats, in turn as often as they fit."""
    turns, length = _before(repeat, records), repeat.end - repeat.start
    shares = [it.end - it.start or length for it in turns]
    times = max(int(length / sum(shares)), 1)
    turns, ends = turns * times, np.cumsum([0.0, *shares * times])
    places = np.rint((repeat.start + ends / ends[-1] * length) * GRID) / GRID
    for it, (start, end) in zip(turns, pairwise(places.tolist()), strict=True):
        if start < end:
            own = replace(repeat, kind=it.kind, direction=it.direction, level=it.level)
            yield replace(own, amount=it.amount, start=start, end=end)


def joined(pages: Sequence[Read]) -> Iterator[tuple[int, Record]]:
    """Yield the signs of pages that follow each other, each with the number of its page, from 0.

    Their times count from the first page on. A repeat is what it stands for, perhaps on the page
    before; positions at the top of later pages are passed over.
    """
    every, before = list[tuple[int, Record]](), 0
    columns = defaultdict[str, list[Record]](list)
    for number, page in enumerate(pages):
        for it in (sign.later(before) for sign in page.records):
            every.append((number, it))
            columns[it.part].append(it)
        before += page.counts
    for number, it in every:
        if it.kind == _REPEAT:
            yield from ((number, one) for one in _written_out(it, columns[it.part]))
        elif not number or it.start < it.end:
            yield number, it


def score_of(pages: Sequence[Read], speed: Fraction) -> Score:
    """Return a score of pages that follow each other, at so many counts a minute."""
    beats = pages[0].beats
    rows: dict[str, list[NDArray[np.void]]] = {}
    signs = sorted((it for _, it in joined(pages)), key=lambda it: (it.part, it.start, it.end))
    for it in signs:
        row = blank(())
        row["start"] = row["tick"] = round(it.start * GRID)
        row["stop"] = round(it.end * GRID)
        row["ticks"], row["margin"] = row["stop"] - row["start"], 1
        row["direction"] = DIRECTION_CODES.get(it.direction or "", -1)
        row["level"] = LEVEL_CODES.get(it.level or "", -1)
        row["amount"] = -1 if it.amount is None else it.amount
        rows.setdefault(it.part, []).append(row)
    if not rows:
        raise CaptureError("no sign that is known", wanted="signs of Labanotation")
    ticks = -(-sum(it.counts for it in pages) // beats) * beats * GRID
    known = (Span(0, ticks),)
    tracks = {part: Track(part, np.array(own, SYMBOL), known) for part, own in rows.items()}
    meter = Meter(speed, beats, 4, GRID * beats)
    return Score(meter.tick_rate, ticks, meter, with_steps(tracks))


def _beats(found: Sequence[Staff], page: Layout) -> int:
    """Return the counts in a bar: between two lines, or from the base to the first; else 4."""
    steps = list[float]()
    for staff, (low, high) in zip(found, pairwise(page.counts), strict=True):
        count = (staff.base - staff.top) / (high - low)
        first, *bars = [(a - b) / count for a, b in pairwise([staff.base, *staff.bars])] or [0.5]
        steps += [first, *bars] if abs(first - round(first)) < 0.15 else bars
    return max(round(float(np.median(steps))), 1) if steps else 4
