"""Pages that were read, as a score: columns become parts, heights become counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, KINDS, LEVEL_CODES, kind_of
from lanindex.data import shipped
from lanindex.draw import svg
from lanindex.draw.picture import PIXEL, C, Label, Picture
from lanindex.draw.staff import name_of
from lanindex.errors import CaptureError
from lanindex.model import SYMBOL, Meter, Score, Span, Track
from lanindex.model.derived import with_steps
from lanindex.model.symbol import blank
from lanindex.reader.signs import SIZE, Column, Page, read
from lanindex.reader.staff import Staff, staves

GRID = 4
"""Steps of a count to which times are rounded."""

DOUBTFUL = 0.75
"""Confidence below which a sign is doubtful."""

_COLUMNS = shipped("draw/signs.toml")["columns"]
_NAMED = 0.5  # likeness of a name below a column, at least
_UNNAMED = {True: ("support", "leg"), False: ("arm", "hand")}
"""Columns whose names cannot be read, outwards: inside of the staff (True), and outside."""


@dataclass(frozen=True, slots=True)
class Record:
    """A sign that was read; one that is not known has no kind."""

    staff: int  # On which it begins, from the left
    part: str  # Of its column
    kind: str  # Of `lanindex.alphabet.KINDS`
    direction: str | None
    level: str | None
    start: float  # Counts from the beginning of the page
    end: float  # A starting position begins and ends at 0
    confidence: float

    @property
    def place(self) -> str:
        """Where it stands, in words."""
        return f"staff {self.staff + 1}, {self.part}, count {self.start:g} to {self.end:g}"


@dataclass(frozen=True, slots=True)
class Read:
    """A page that was read."""

    records: list[Record]
    unknown: list[Record]
    beats: int  # Counts in a bar
    counts: int  # On the page


def read_page(image: NDArray[np.uint8]) -> list[Record]:
    """Return the signs of a page, (H, W) grey, that are known."""
    return read_signs(image).records


def read_signs(image: NDArray[np.uint8]) -> Read:
    """Return the signs of a page, (H, W) grey, known and unknown."""
    found = staves(image)
    page = read(found)
    parts = {it.number: part for it, part in _parts(found[0], page)}
    records = list[Record]()
    for sign in page.signs:
        part = parts[sign.column.number]
        kind = kind_of(part)
        fits = sign.kind == "sign" and {"direction", "level"} <= {*KINDS[kind].fields}
        below = sign.start < -0.5 / GRID
        start, end = (0.0 if below else round(it * GRID) / GRID for it in (sign.start, sign.end))
        staff = sum(it <= start for it in page.counts[1:-1])
        if sign.kind != "hold":
            name = kind if fits and (below or start < end) else ""
            what = sign.direction, sign.level
            records.append(Record(staff, part, name, *what, start, end, sign.confidence))
    beats = _beats(found, page)
    known, unknown = [it for it in records if it.kind], [it for it in records if not it.kind]
    return Read(known, unknown, beats, round(page.counts[-1]))


def score_of(pages: Sequence[Read], speed: Fraction) -> Score:
    """Return a score of pages that follow each other, at so many counts a minute."""
    beats = pages[0].beats
    rows: dict[str, list[NDArray[np.void]]] = {}
    before = 0
    for page in pages:
        for it in sorted(page.records, key=lambda it: (it.part, it.start, it.end)):
            if before and it.end == 0:
                continue  # the position at the top of the page before
            row = blank(())
            row["start"] = row["tick"] = round((before + it.start) * GRID)
            row["stop"] = round((before + it.end) * GRID)
            row["ticks"], row["margin"] = row["stop"] - row["start"], 1
            row["direction"], row["level"] = (
                DIRECTION_CODES[it.direction or ""],
                LEVEL_CODES[it.level or ""],
            )
            rows.setdefault(it.part, []).append(row)
        before += page.counts
    if not rows:
        raise CaptureError("no sign that is known", wanted="signs of direction and level")
    ticks = -(-before // beats) * beats * GRID
    known = (Span(0, ticks),)
    tracks = {part: Track(part, np.array(own, SYMBOL), known) for part, own in rows.items()}
    meter = Meter(speed, beats, 4, GRID * beats)
    return Score(meter.tick_rate, ticks, meter, with_steps(tracks))


def _beats(found: Sequence[Staff], page: Page) -> int:
    """Return the counts in a bar: between two lines, or from the base to the first; else 4."""
    steps = list[float]()
    for staff, (low, high) in zip(found, pairwise(page.counts), strict=True):
        count = (staff.base - staff.top) / (high - low)
        ys = [staff.base, *staff.bars]
        steps += [(a - b) / count for a, b in pairwise(ys)]
    return max(round(float(np.median(steps))), 1) if steps else 4


def _parts(staff: Staff, page: Page) -> list[tuple[Column, str]]:
    """Return the part of each column: as the name below says, or else by its place."""
    found = list[tuple[Column, str]]()
    taken = set[str]()
    for column in page.columns:
        pairs = _COLUMNS["inside" if column.inside else "outside"]
        own = [pair[column.number < 0] for pair in pairs]
        by_name = {name_of(part): part for part in own if part and part not in taken}
        name, likeness = _name(staff, page, column, tuple(by_name))
        if likeness < _NAMED:
            inner = sum(it.inside for it in page.columns) // 2
            number = abs(column.number) - (0 if column.inside else inner) - 1
            usual = _UNNAMED[column.inside]
            name = usual[min(number, len(usual) - 1)]
        part = by_name.get(name) or f"column {column.number}"
        taken.add(part)
        found.append((column, part))
    return found


def _name(staff: Staff, page: Page, column: Column, names: tuple[str, ...]) -> tuple[str, float]:
    """Return the name below a column, and how much it is like it."""
    unit = page.unit * staff.inner
    x = staff.centre + column.x * unit
    rows = slice(round(staff.foot + 0.3 * unit), round(staff.foot + 6 * unit))
    ink = 1 - staff.image[rows, max(round(x - 0.6 * unit), 0) : round(x + 0.6 * unit)] / np.float32(
        255
    )
    if min(ink.shape) < 4 or ink.max() < 0.2:
        return "", 0.0
    factor = SIZE / unit
    how = cv2.INTER_CUBIC if factor > 1 else cv2.INTER_AREA
    lying = cv2.resize(
        cv2.rotate(ink, cv2.ROTATE_90_CLOCKWISE), None, fx=factor, fy=factor, interpolation=how
    )
    lying = cv2.copyMakeBorder(lying, 8, 8, 8, 8, cv2.BORDER_CONSTANT, value=0)
    noise = np.random.default_rng(0).uniform(0, 0.02, lying.shape)
    paper = np.asarray(lying + noise, np.float32)  # what is flat would be like any name
    best = "", 0.0
    for name in names:
        template = _word(name)
        if template.shape[0] <= lying.shape[0] and template.shape[1] <= lying.shape[1]:
            value = float(cv2.matchTemplate(paper, template, cv2.TM_CCOEFF_NORMED).max())
            # of two that fit, the longer one says more: "leg" stands in "leg bend"
            best = max(best, (name, value + 0.01 * len(name)), key=lambda it: it[1])
    return best


@lru_cache(maxsize=64)
def _word(text: str) -> NDArray[np.float32]:
    """Return a name as it is printed below a column, lying: (H, W) of darkness."""
    size = round(0.45 * C)
    wide = round(0.75 * size * len(text)) + size
    picture = Picture(wide, 2 * size, "", "", (Label(wide // 2, round(1.4 * size), text, size),))
    drawn = svg.image(svg.write(picture, scale=SIZE * PIXEL / C * 4, ink=svg.INK))
    large = np.asarray(cv2.imdecode(np.frombuffer(drawn, np.uint8), cv2.IMREAD_GRAYSCALE))
    ink = 1 - cv2.resize(large, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA) / np.float32(
        255
    )
    rows, across = np.flatnonzero(ink.max(axis=1) > 0.1), np.flatnonzero(ink.max(axis=0) > 0.1)
    cut = ink[rows[0] : rows[-1] + 1, across[0] : across[-1] + 1]
    return np.asarray(
        cv2.GaussianBlur(cv2.copyMakeBorder(cut, 1, 1, 2, 2, cv2.BORDER_CONSTANT), (0, 0), 0.6)
    )
