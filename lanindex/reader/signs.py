"""What stands in the columns of a page: signs, and ink that is none that is known.

The ink of a column is cut where it has gaps or lighter rows, and the cuts are chosen so that the
pieces are as much like signs as can be. A sign that is known there is drawn at the piece's height
(`lanindex.reader.templates`) and compared with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from math import erf, log2, sqrt
from typing import Any

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from lanindex.alphabet import kind_of
from lanindex.draw.picture import C
from lanindex.draw.staff import BOTH, ONE, PITCH
from lanindex.reader.across import flights, touches
from lanindex.reader.layout import BELOW, WIDEST, Layout, Piece
from lanindex.reader.names import Column
from lanindex.reader.outlines import named
from lanindex.reader.staff import runs
from lanindex.reader.templates import (
    ACROSS,
    APART,
    COARSE,
    DEGREES,
    NAMES,
    PAD,
    SEAM,
    SIZE,
    SPREAD,
    STROKE,
    UNIT,
    Floats,
    Name,
    across,
    fits,
    image,
    ring,
)

_SHIFT = 2  # pixels by which a sign may lie elsewhere than its column or its ink says
_INK = 0.3  # darkness of a row from which on it belongs to a sign; less, if signs are blurred
_LOST = 4  # rows at the lower end of a circle that are not compared
_ROUND = 0.7  # likeness from which on it is a circle
_SURE = 0.5  # likeness below which a piece is unknown
_OURS = 0.55  # likeness of a page to our signs, below which it may be in another style
_COST = 3.0  # worth that each sign costs, so that one is not read as two by chance
_SEAM = 8.0  # the same for each cut in ink without a gap that is seen
_CLEAR = 1.0  # blur up to which gaps are seen
_POOR = 0.27  # worth of a row below which a piece is cut anew, where a quarter of a count begins
_MOST = 20  # cuts that a sign may span
_STEPS = tuple(range(15, 375, 15))  # degrees that are written
_CLOSE = 0.02  # likeness by which degrees must be told from others


@dataclass(frozen=True, slots=True)
class Sign:
    """A sign in a column; what is not known has no name."""

    column: Column
    start: float  # Counts from the first staff's base on; a starting position lies below 0
    end: float
    name: Name | None
    confidence: float  # 0 to 1


@dataclass(frozen=True, slots=True)
class _Cut:
    """A stretch of ink as it is cut, rows half-open from its top."""

    top: int
    foot: int
    name: Name | None
    worth: float


_Found = list[tuple[Column, Piece]]
"""What stands on a page, and where."""


def read(page: Layout) -> Iterator[Sign]:
    """Yield the signs of a page."""
    ink = page.ink.copy()
    blur = _blur(page)
    centre = Column("body_turn", 0.0, inside=True, half=PITCH / C)
    beside = [*touches(page, ink, blur)]  # first, for their bows cross the columns of others
    feet = [it for it in page.columns if kind_of(it.part) == "support"]
    sizes = [(centre, BOTH), *((it, ONE) for it in feet)]
    found: _Found = [
        (place, it) for place, size in sizes for it in _circles(ink, place, size, blur)
    ]
    whole = ink.copy()
    turns = [*_turns(page, ink, blur)]
    beside += flights(whole, ink, [(round(it.top), round(it.foot)) for it in turns], blur)
    found += [(centre, it) for it in turns]
    found += beside
    found += [(it, sign) for it in page.columns for sign in _Reader(ink, page, it, blur).pieces()]
    if _likeness(found) < _OURS:  # in another style, which has no flights and circles, or damaged
        readers = [(it, _Reader(page.ink, page, it, blur)) for it in page.columns]
        outlined = [(it, sign) for it, reader in readers for sign in reader.outlined()]
        found = max(found, outlined, key=_likeness)
    base = len(ink) - BELOW
    for place, it in found:
        start, end = ((base - row) / page.rows for row in (it.foot, it.top))
        yield Sign(place, start, end, it.name, it.likeness)


def _likeness(found: _Found) -> float:
    """Return how much what stands in the columns of limbs is like signs, by its height."""
    own = [it for column, it in found if kind_of(column.part) in ("gesture", "support")]
    rows = sum(it.foot - it.top for it in own)
    return sum((it.foot - it.top) * it.likeness for it in own) / rows if rows else 1.0


_BLURS = (0.5, 0.8, 1.2, 1.7, 2.3, 3.1)
"""Pixels by which signs may be blurred."""


def _blur(page: Layout) -> float:
    """Return by how much signs are blurred that a few pieces of ink are most like."""
    totals = dict.fromkeys(_BLURS, 0.0)
    for column in page.columns:
        reader = _Reader(page.ink, page, column, _BLURS[1])
        places, inked, *_ = reader.places()
        spans = [
            it for it, ink in zip(pairwise(places), inked, strict=True)
            if ink and 0.7 * SIZE < it[1] - it[0] < 5 * SIZE
        ]  # fmt: skip
        for top, foot in spans[: 24 // len(page.columns) + 1]:
            if name := reader.named(top, foot, whole=True)[1]:
                for blur in _BLURS:
                    totals[blur] += reader.fitted(top, foot, name, blur)[0]
    return max(_BLURS, key=totals.__getitem__)


def _strip(ink: Floats, x: float, wide: int) -> Floats:
    """Return so many columns of ink (H, W) round a place, from the centre line."""
    first = round(x + WIDEST * SIZE - wide / 2)
    return np.ascontiguousarray(ink[:, first : first + wide])


def _cuts(page: Layout, top: int, foot: int) -> tuple[int, ...]:
    """Return the heights at which a piece continues on the next staff."""
    return tuple(foot - it for it in page.ends if top + 3 < it < foot - 3)


def _turns(page: Layout, ink: Floats, blur: float) -> Iterator[Piece]:
    """Yield the turns across the centre line, and take them out of the ink (H, W)."""
    near, half = _strip(ink, 0, SIZE // 2), SIZE // 4
    sides = [
        side.mean(axis=1, keepdims=True) for side in (near[:, : half - 1], near[:, half + 1 :])
    ]
    thick = np.ones((5, 1))
    inked = runs(np.minimum(*(cv2.dilate(it, thick)[:, 0] for it in sides)) > 0.25)
    at = 0
    while at + 1 < len(inked):
        ends = [sum(it) // 2 for it in inked[at : at + 6]]
        found = [it for end in ends[1:] if (it := _turn(page, ink, ends[0], end, blur))]
        at += 1
        if found:
            piece, own = max(found, key=lambda it: it[0].likeness)
            yield piece
            _erase(ink, own, round(piece.top) - PAD)
            while at < len(inked) and inked[at][1] < piece.foot:
                at += 1


def _circles(ink: Floats, place: Column, size: int, blur: float) -> Iterator[Piece]:
    """Yield the circles of a size in a place, and take them out of the ink (H, W).

    Their lower ends often lie on a line of the staff, and went with it.
    """
    circle = ring(size, blur)
    strip = _strip(ink, place.x * SIZE, SIZE + 2 * PAD)
    likeness = cv2.matchTemplate(strip, circle[:-_LOST], cv2.TM_CCOEFF_NORMED)[:, 0]
    while (y := int(likeness.argmax())) >= 0 and likeness[y] > _ROUND:
        yield Piece(y + PAD, y + len(circle) - PAD, Name("hold"), float(likeness[y]))
        _erase(ink, circle, y, place.x * SIZE)
        likeness[max(y - SIZE // 2, 0) : y + SIZE // 2] = 0


def _turn(
    page: Layout, ink: Floats, high: int, low: int, blur: float
) -> tuple[Piece, Floats] | None:
    """Return the turn whose edges cross the centre line at two rows, and its image; or None."""
    slant = min((low - high) // 2, SIZE // 2)  # by a third of its height, or by a half width
    top, foot = high - slant // 2 - 2, low + slant // 2 + 2
    if foot - top < SIZE // 2 or top < _SHIFT or foot > len(ink) - _SHIFT:
        return None
    strip = _strip(ink[top - _SHIFT : foot + _SHIFT], 0, SPREAD + 2 * _SHIFT)
    cuts = _cuts(page, top, foot)
    options = [(name, foot - top - less) for name in ACROSS for less in range(5)]
    values = [_like(strip, across(*it, cuts, blur)) for it in options]
    value, row = max(values)
    name, size = options[values.index((value, row))]
    name, value = _with_degrees(name, lambda it: _like(strip, across(it, size, cuts, blur))[0])
    if value < _SURE:
        return None
    begin = top - _SHIFT + row + PAD
    return Piece(begin, begin + size, name, value), across(name, size, cuts, blur)


def _with_degrees(name: Name, likeness: Callable[[Name], float]) -> tuple[Name, float]:
    """Return a sign with the degrees that it is most like, or without, and how much it is so.

    If other degrees are nearly as like, it is doubtful.
    """
    plain = likeness(name)
    found = sorted(
        ((likeness(it), it) for it in (name._replace(amount=step) for step in _STEPS)),
        key=lambda it: -it[0],
    )
    (value, best), (second, _) = found[:2]
    if value < plain + 0.01:
        return name, plain
    return best, value if value > second + _CLOSE else min(value, _SURE)


def _like(strip: Floats, own: Floats) -> tuple[float, int]:
    """Return how much a strip is like an image, at best, and at which row."""
    if len(own) > len(strip):
        return 0.0, 0
    likeness = cv2.matchTemplate(strip, own, cv2.TM_CCOEFF_NORMED)
    _, value, _, (_, y) = cv2.minMaxLoc(likeness)
    return float(value), y


def _erase(ink: Floats, own: Floats, top: int, x: float = 0) -> None:
    """Take what is seen of an image round a place, from the centre line, out of ink (H, W)."""
    first = round(x + WIDEST * SIZE - own.shape[1] / 2)
    dark = cv2.dilate(own, np.ones((5, 5), np.uint8)) > 0.15
    ink[top : top + len(own), first : first + own.shape[1]][dark] = 0


class _Reader:
    """The reading of a column."""

    def __init__(self, ink: Floats, page: Layout, column: Column, blur: float) -> None:
        self.strip = _strip(ink, column.x * SIZE, SIZE + 2 * PAD + 2 * _SHIFT)
        half = self.strip.shape[1] // 2, len(self.strip) // 2
        small = cv2.resize(self.strip[: 2 * half[1]], half, interpolation=cv2.INTER_AREA)
        self.small = np.pad(small, ((_EDGE, _EDGE), (0, 0)))
        self.names = NAMES[kind_of(column.part)]
        self.page, self.left, self.blur = page, column.x < 0, blur
        self.known = dict[tuple[int, int], tuple[float, Name | None]]()
        self.hidden = page.ends  # gaps that are not seen
        if column.inside:
            self.hidden = [*page.ends, *page.bars]
        self.gaps = any(it.kind in APART for it in self.names)

    def pieces(self) -> Iterator[Piece]:
        """Yield signs, upwards, and pieces of ink that are none."""
        found, stretches = self._cut([])
        poor = [it for it in found if it.worth < _POOR * (it.foot - it.top)]
        if poor and self.blur > _CLEAR:
            base = len(self.strip) - BELOW
            quarters = np.rint(base - np.arange(4 * base / self.page.rows) * self.page.rows / 4)
            again = [run for run in stretches if any(run[0] <= it.top < run[1] for it in poor)]
            rows = [int(it) for it in quarters if any(top < it < foot for top, foot in again)]
            found, _ = self._cut(rows)
        unknown = None
        for it in found:
            if it.name:
                yield self._settled(it.top, it.foot, it.name)
            elif unknown and unknown.top == it.foot:
                unknown = replace(unknown, top=it.top)
            else:
                if unknown:
                    yield unknown
                unknown = Piece(it.top, it.foot, None, 0.0)
        if unknown:
            yield unknown

    def _cut(self, more: list[int]) -> tuple[list[_Cut], list[tuple[int, int]]]:
        """Return pieces of ink, upwards, cut so that they are worth most, and stretches of ink.

        There may be cuts at so many rows `more`.
        """
        places, inked, seams, stretches = self.places(more)
        best: list[tuple[float, int, float, Name | None]] = [(0.0, -1, 0.0, None)]
        for end in range(1, len(places)):
            rows = places[end] - places[end - 1]
            cost = 0.02 * rows if inked[end - 1] else 0.0
            options: list[tuple[float, int, float, Name | None]] = [
                (best[end - 1][0] - cost, end - 1, 0.0, None)
            ]
            first = max(end - _MOST, 0) if inked[end - 1] else end
            for begin in range(end - 1, first - 1, -1):
                whole = all(inked[begin:end])
                if not (whole or self.gaps):
                    break
                if inked[begin]:
                    worth, name = self.named(places[begin], places[end], whole=whole)
                    if name is not None:
                        value = best[begin][0] + worth - _COST - seams[begin]
                        options.append((value, begin, worth, name))
            best.append(max(options, key=lambda it: it[0]))
        at, found = len(places) - 1, list[_Cut]()
        while at > 0:
            _, before, worth, name = best[at]
            if name or inked[before]:
                found.append(_Cut(places[before], places[at], name, worth))
            at = before
        return found, stretches

    def outlined(self) -> Iterator[Piece]:
        """Yield signs in another style than ours, upwards, and pieces of ink that are none."""
        kind = self.names[0].kind
        for top, foot in reversed(runs(self.strip[:, 2:-2].max(axis=1) > _INK)):
            found: tuple[Name | None, float] = None, 0.0
            if Name(kind, "place", "low") in self.names:
                found = named(self.strip[top:foot], kind, left=self.left)
            yield Piece(top, foot, *found)

    def places(
        self, more: Sequence[int] = ()
    ) -> tuple[list[int], list[bool], list[float], list[tuple[int, int]]]:
        """Return the rows at which signs may begin or end, and whether there is ink between.

        And what it costs that one ends there though no gap is seen where one would be; and the
        stretches of ink. There may be cuts at so many rows `more`.
        """
        rows = self.strip[:, 2:-2].max(axis=1)
        stroke = erf(STROKE * UNIT / 2 / (self.blur * sqrt(2)))  # darkness of a blurred one
        places, inked, seams = list[int](), list[bool](), list[float]()
        stretches = [it for it in runs(rows > min(_INK, stroke / 2)) if it[1] - it[0] >= 3]
        for top, foot in stretches:
            own = rows[top:foot]
            cuts = {
                top + it
                for it in range(SIZE // 3, len(own) - SIZE // 3)
                if own[it] < 0.8 * min(own[it - 4 : it].max(), own[it + 1 : it + 5].max())
                and own[it] == own[max(it - 3, 0) : it + 4].min()
            }
            ends = top + SIZE // 3, foot - SIZE // 3
            cuts |= {it for it in self.page.lines if ends[0] < it < ends[1]}
            near = [it for it in more if all(abs(it - cut) > SIZE // 5 for cut in cuts)]
            cuts |= {it for it in near if ends[0] < it < ends[1]}
            inked += [False] * bool(places)
            inside = sorted(cuts)
            places += [top, *inside, foot]
            seams += [0.0, *(self._seam(rows, it) for it in inside), 0.0]
            inked += [True] * (len(inside) + 1)
        return places, inked, seams, stretches

    def _seam(self, rows: Floats, row: int) -> float:
        """Return what it costs that signs meet at a row, by how dark rows (H,) are around it."""
        if any(abs(it - row) <= SEAM for it in self.hidden):
            return 0.0
        sides = min(rows[row - 6 : row - 1].max(), rows[row + 2 : row + 7].max())
        gap = float(rows[row - 2 : row + 3].min() / max(sides, 0.01))
        return _SEAM * min(max((gap - 0.8) / 0.2, 0.0), 1.0)

    def named(self, top: int, foot: int, *, whole: bool) -> tuple[float, Name | None]:
        """Return the sign that a piece is most like, and its worth: more, the higher and surer."""
        if (top, foot) not in self.known:
            self.known[top, foot] = self._named(top, foot, whole=whole)
        return self.known[top, foot]

    def _named(self, top: int, foot: int, *, whole: bool) -> tuple[float, Name | None]:
        high = (foot - top) / SIZE
        names = tuple(it for it in self.names if (whole or it.kind in APART) and fits(it, high))
        best: tuple[float, Name | None] = 0.0, None
        cuts = tuple(it // 2 for it in _cuts(self.page, top, foot))
        low = top // 2 + _EDGE - PAD - 1
        if self.blur > _CLEAR and len(names) > _LIKELY and foot - top > SIZE // 2:
            names = self._likely(names, top, foot)
        for size in ((foot - top) // 2, (foot - top - 1) // 2) if names else ():
            images = [image(it, size, self.left, cuts, self.blur, COARSE) for it in names]
            known = np.array(images).reshape(len(names), -1)
            near = self.small[low : low + size + 2 * PAD + 2]
            windows = sliding_window_view(near, (size + 2 * PAD, COARSE + 2 * PAD))
            likeness = _alike(windows.reshape(-1, known.shape[1]), known)
            at = int(likeness.argmax())
            value = float(likeness.flat[at])
            worth = (value * abs(value) - _SURE**2) * size
            if value > _SURE and worth > best[0]:
                best = worth, names[at % len(names)]
        return best

    def _likely(self, names: tuple[Name, ...], top: int, foot: int) -> tuple[Name, ...]:
        """Return the names of signs that a piece is most like where both are made small."""
        height = round(COARSE * 2 ** (round(8 * log2((foot - top) / SIZE)) / 8))
        piece = self.small[top // 2 + _EDGE : foot // 2 + _EDGE, 2:-2]
        seen = cv2.resize(piece, _ROUGH, interpolation=cv2.INTER_AREA).reshape(1, -1)
        likeness = _alike(seen, _rough(names, height, self.left, self.blur))[0]
        return tuple(names[it] for it in np.sort(np.argsort(-likeness)[:_LIKELY]).tolist())

    def fitted(self, top: int, foot: int, name: Name, blur: float) -> tuple[float, int, int]:
        """Return how much a piece is like a sign at the best of its places: its row and height."""
        low, high = max(top - 3, 0), min(foot + 3, len(self.strip))
        piece, cuts = self.strip[low:high], _cuts(self.page, top, foot)
        best = 0.0, 0, foot - top
        for size in range(foot - top - 3, foot - top + 3):
            value, y = _like(piece, image(name, size, self.left, cuts, blur))
            best = max(best, (value, low + y + PAD, size))
        return best

    def _settled(self, top: int, foot: int, name: Name) -> Piece:
        """Return a sign with its ends found more closely, and what is written in it."""
        value, row, size = self.fitted(top, foot, name, self.blur)
        if name.kind in DEGREES:
            near = self.strip[max(row - PAD - 1, 0) : row + size + PAD + 1]
            cuts = _cuts(self.page, top, foot)

            def likeness(it: Name) -> float:
                return _like(near, image(it, size, self.left, cuts, self.blur))[0]

            name, value = _with_degrees(name, likeness)
        return Piece(row, row + size, name, max(value, 0.0))


_EDGE = 4  # rows of paper above and below a column that is made small


_ROUGH = 7, 14  # pixels, across and down, of signs that are compared roughly
_LIKELY = 8  # signs that are compared closely


@lru_cache(maxsize=256)
def _rough(names: tuple[Name, ...], height: int, left: bool, blur: float) -> Floats:
    """Return rough images of signs at a height in pixels of `COARSE`, (N, H * W)."""
    drawn = [image(it, height, left, (), blur, COARSE)[PAD:-PAD, PAD:-PAD] for it in names]
    rows = [cv2.resize(it, _ROUGH, interpolation=cv2.INTER_AREA).ravel() for it in drawn]
    return np.array(rows, np.float32)


def _alike(seen: NDArray[Any], known: NDArray[Any]) -> Floats:
    """Return how much images (M, P) are like others (N, P): (M, N) correlations."""
    own, other = (it - it.mean(axis=1, keepdims=True) for it in (seen, known))
    lengths = [np.maximum(np.einsum("ij,ij->i", it, it), 1e-3) for it in (own, other)]
    return np.asarray(own @ other.T / np.sqrt(np.outer(*lengths)), np.float32)
