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
from math import erf, inf, log2, sqrt
from operator import itemgetter
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from lanindex.alphabet import kind_of
from lanindex.draw.picture import C
from lanindex.draw.staff import BOTH, ONE, PITCH
from lanindex.reader.across import flights, touches
from lanindex.reader.layout import BELOW, NEAR, Layout, Piece
from lanindex.reader.names import WIDEST, Column
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
    mean_across,
    mean_image,
    ring,
)

_SHIFT = 2  # pixels by which a sign may lie elsewhere than its column or its ink says
_INK = 0.3  # darkness of a row from which on it belongs to a sign; less, if signs are blurred
_DARK = 92  # percentile of the darkness of a row that tells where ink begins: a thin line's, too
_ANEW = -0.4  # pixels into a staff from which on a sign that begins there is another one
_LOST = 4  # rows at the lower end of a circle that are not compared
_ROUND = 0.7  # likeness from which on it is a circle
_SURE = 0.5  # likeness below which a piece is unknown
_OURS = 0.55  # likeness of a page to our signs, below which it may be in another style
_COST = 4.0  # worth that each sign costs, so that one is not read as two by chance
_SEAM = 8.0  # the same for each cut in ink without a gap that is seen
_GAP = 0.3  # share of its worth that it costs that a sign goes on where a gap is seen
_GOES_ON = 4.0  # the same where a staff ends, of signs that are drawn anew on the next one
_CLEAR = 1.0  # blur up to which gaps are seen
_SKIP = 0.02  # what a row of ink costs that is not known
_POOR = 0.2  # worth of a row below which a piece is cut anew, where a quarter of a count begins
_AROUND = 1.5  # quarters of a count above and below it at which it is
_SOME = 0.42  # likeness where signs are made small, below which it is not looked at more closely
_MARGIN = 30.0  # worth by which ways to cut a column may be less than the best and be looked at
_FEW = 3  # signs that a piece is most like
_LOW = SIZE // 4  # rows: what is lower is no sign, but left of a line or a sign beside
_PAPER = 0.05  # share of a sign's ink below which there is none of it
_PALE = 0.4  # share of a sign's ink that a piece has at least
_LONG = 2 * SIZE  # rows from which on the strokes of a sign may be nearer or farther than drawn
_NEARER = (-0.045, -0.03, -0.015, 0.015, 0.03, 0.045)  # by these shares
_MOST = 32  # cuts that a sign may span
_STEPS = (5, *range(15, 375, 15))  # degrees that are tried first
_CLOSE = 0.004  # likeness by which degrees must be told from others


@dataclass(frozen=True, slots=True)
class Sign:
    """A sign in a column; what is not known has no name."""

    column: Column
    start: float  # Counts from the first staff's base on; a starting position lies below 0
    end: float
    name: Name | None
    confidence: float  # 0 to 1


class _Place(NamedTuple):
    """A row at which signs may begin or end."""

    row: int
    inked: bool = False  # Whether there is ink from there to the next place below
    seam: float = 0.0  # What it costs that signs meet there though no gap is seen
    gap: float = 0.0  # How surely a gap is seen there, 0 to 1


class _Candidate(NamedTuple):
    """A piece between two of the rows at which a column may be cut, half-open from its top."""

    top: int
    foot: int
    name: Name | None
    worth: float
    cost: float

    @property
    def value(self) -> float:
        return self.worth - self.cost


def _best(candidates: Sequence[_Candidate]) -> list[_Candidate]:
    """Return the candidates that follow each other and are worth most.

    Candidates are in the order of their feet, and lead from the first one's top to the last foot.
    """
    last: dict[int, tuple[float, _Candidate | None]] = {candidates[0].top: (0.0, None)}
    for it in candidates:
        so_far = last.get(it.foot, (-inf, None))
        last[it.foot] = max(so_far, (last[it.top][0] + it.value, it), key=itemgetter(0))
    found, candidate = list[_Candidate](), last[candidates[-1].foot][1]
    while candidate:
        found.append(candidate)
        candidate = last[candidate.top][1]
    return found[::-1]


def _near_best(candidates: Sequence[_Candidate], margin: float) -> list[_Candidate]:
    """Return the candidates on ways that are worth less than the best one by a margin, at most."""
    ahead, behind = {candidates[0].top: 0.0}, {candidates[-1].foot: 0.0}
    for it in candidates:
        ahead[it.foot] = max(ahead.get(it.foot, -inf), ahead[it.top] + it.value)
    for it in reversed(candidates):
        behind[it.top] = max(behind.get(it.top, -inf), behind[it.foot] + it.value)
    least = ahead[candidates[-1].foot] - margin
    return [it for it in candidates if ahead[it.top] + it.value + behind[it.foot] >= least]


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
        spans = [
            (top.row, foot.row)
            for top, foot in pairwise(reader.places())
            if top.inked and 0.7 * SIZE < foot.row - top.row < 5 * SIZE
        ]
        for top, foot in spans[: 24 // len(page.columns) + 1]:
            worth, name = reader.named(top, foot, whole=True)
            if name and worth > 0:
                if name.kind in DEGREES:  # what is written in it is sharper than any mean of it
                    name, _ = reader.with_degrees(top, foot, name)
                for blur in _BLURS:
                    totals[blur] += reader.fitted(top, foot, name, blur)[0]
    return max(_BLURS, key=totals.__getitem__)


def _strip(ink: Floats, x: float, wide: int) -> Floats:
    """Return so many columns of ink (H, W) round a place, from the centre line."""
    first = round(x + WIDEST * SIZE - wide / 2)
    return np.ascontiguousarray(ink[:, first : first + wide])


def _begins(near: Floats) -> float:
    """Return how far into a staff ink begins, in pixels from its end, by what is around that."""
    rows = np.percentile(near[NEAR - SEAM : NEAR + 2 * SEAM], _DARK, axis=1)
    half = max(float(rows.max()), _INK) / 2
    first = int(np.argmax(rows > half))
    if first:
        first -= (rows[first] - half) / (rows[first] - rows[first - 1])
    return float(first - SEAM) if rows.max() > half else SEAM


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
    ends = [(top + foot) // 2 for top, foot in inked]
    candidates, found = list[_Candidate](), dict[tuple[int, int], Piece]()
    for at, foot in enumerate(ends):
        candidates += [_Candidate(it, foot, None, 0.0, 0.0) for it in ends[at - 1 : at]]
        cost = _COST + _GOES_ON * any(abs(it - foot) <= 2 * SEAM for it in page.ends)
        for top in ends[max(at - 5, 0) : at]:
            if turn := _turn(page, ink, top, foot, blur):
                found[top, foot] = turn
                worth = _worth(turn.likeness, turn.foot - turn.top)
                candidates.append(_Candidate(top, foot, turn.name, worth, cost))
    for it in _best(candidates) if candidates else ():
        if it.name:
            yield _turned(page, ink, found[it.top, it.foot], blur)


def _circles(ink: Floats, place: Column, size: int, blur: float) -> Iterator[Piece]:
    """Yield the circles of a size in a place, and take them out of the ink (H, W).

    Their lower ends often lie on a line of the staff, and went with it.
    """
    circle = ring(size, blur)
    strip = _strip(ink, place.x * SIZE, SIZE + 2 * PAD)
    likeness = _likenesses(strip, circle[:-_LOST])[:, 0]
    while (y := int(likeness.argmax())) >= 0 and likeness[y] > _ROUND:
        yield Piece(y + PAD, y + len(circle) - PAD, Name("hold"), float(likeness[y]))
        _erase(ink, circle, y, place.x * SIZE)
        likeness[max(y - SIZE // 2, 0) : y + SIZE // 2] = 0


def _turn(page: Layout, ink: Floats, high: int, low: int, blur: float) -> Piece | None:
    """Return the turn whose edges cross the centre line at two rows, without degrees; or None."""
    slant = min((low - high) // 2, SIZE // 2)  # by a third of its height, or by a half width
    top, foot = high - slant // 2 - 2, low + slant // 2 + 2
    if foot - top < SIZE // 2 or foot > len(ink) - _SHIFT:
        return None
    above = max(top - _SHIFT, 0)
    strip = _strip(ink[above : foot + _SHIFT], 0, SPREAD + 2 * _SHIFT)
    cuts = _cuts(page, top, foot)
    options = [(name, foot - top - less) for name in ACROSS for less in range(5)]
    plain = {it: _like(strip, across(*it, cuts, blur))[0] for it in options}
    likely = sorted(plain, key=plain.__getitem__)[-_FEW:]
    if plain[likely[-1]] < _SURE - 0.2:  # not worth drawing with degrees
        return None
    (value, row), (name, size) = max(
        ((_like(strip, mean_across(*it, cuts, blur)), it) for it in likely), key=itemgetter(0)
    )
    if value < _SURE:
        return None
    begin = above + row + PAD
    return Piece(begin, begin + size, name, value)


def _turned(page: Layout, ink: Floats, turn: Piece, blur: float) -> Piece:
    """Return a turn across the centre line with its degrees, and take it out of ink (H, W)."""
    top, foot = round(turn.top), round(turn.foot)
    strip = _strip(ink[max(top - PAD - _SHIFT, 0) : foot + PAD + _SHIFT], 0, SPREAD + 2 * _SHIFT)
    cuts = _cuts(page, top, foot)
    assert turn.name
    name, value = _with_degrees(
        turn.name, lambda it: _like(strip, across(it, foot - top, cuts, blur))[0]
    )
    _erase(ink, across(name, foot - top, cuts, blur), top - PAD)
    return replace(turn, name=name, likeness=max(value, 0.0))


def _worth(likeness: float, rows: float) -> float:
    """Return what it is worth that a piece of so many rows is so much like a sign."""
    return (likeness * abs(likeness) - _SURE**2) * rows / 2


def _with_degrees(name: Name, likeness: Callable[[Name], float]) -> tuple[Name, float]:
    """Return a sign with the degrees that it is most like, or without, and how much it is so.

    If other degrees are nearly as like, it is doubtful.
    """
    plain = likeness(name)
    values = {it: likeness(name._replace(amount=it)) for it in _STEPS}
    if max(values.values()) < plain + 0.01:
        return name, plain
    for place in (0, 1, 2) * 2:  # each digit in turn, twice: the pin turns with all of them
        digits = str(max(values, key=values.__getitem__))
        for digit in range(place == 0, 10) if place < len(digits) else ():
            number = int(f"{digits[:place]}{digit}{digits[place + 1 :]}")
            if number not in values:
                values[number] = likeness(name._replace(amount=number))
    (best, value), (_, second) = sorted(values.items(), key=lambda it: -it[1])[:2]
    return name._replace(amount=best), value if value > second + _CLOSE else min(value, _SURE)


def _like(strip: Floats, own: Floats) -> tuple[float, int]:
    """Return how much a strip is like an image, at best, and at which row."""
    if len(own) > len(strip):
        return 0.0, 0
    _, value, _, (_, y) = cv2.minMaxLoc(_likenesses(strip, own))
    return float(value), y


def _likenesses(strip: Floats, own: Floats) -> Floats:
    """Return how much a strip is like an image at each place, (rows, columns); paper never is."""
    likeness = cv2.matchTemplate(strip, own, cv2.TM_CCOEFF_NORMED)
    height, width = own.shape
    sums = cv2.integral(strip)  # of paper alone OpenCV tells any likeness
    ink = sums[height:, width:] - sums[:-height, width:] - sums[height:, :-width]
    likeness[ink + sums[:-height, :-width] < _PAPER * own.sum()] = 0
    return np.asarray(likeness, np.float32)


def _erase(ink: Floats, own: Floats, top: int, x: float = 0) -> None:
    """Take what is seen of an image round a place, from the centre line, out of ink (H, W)."""
    first = round(x + WIDEST * SIZE - own.shape[1] / 2)
    dark = cv2.dilate(own, np.ones((5, 5), np.uint8)) > 0.15
    ink[top : top + len(own), first : first + own.shape[1]][dark] = 0


class _Reader:
    """The reading of a column."""

    def __init__(self, ink: Floats, page: Layout, column: Column, blur: float) -> None:
        wide = SIZE + 2 * PAD + 2 * _SHIFT
        self.strip = _strip(ink, column.x * SIZE, wide)
        self.names = NAMES[kind_of(column.part)]
        self.hidden = [*page.ends, *(page.bars if column.inside else ())]  # gaps that are not seen
        if self.names[0].kind == "gesture" and not column.inside:  # no lines of the staff are there
            for end, *near in zip(page.ends, page.tops, page.bases, strict=True):
                top, base = (_strip(it, column.x * SIZE, wide) for it in near)
                if _begins(top) + _begins(base[::-1]) > 2 * _ANEW:  # the gap was drawn over
                    self.strip[end - SEAM : end] = base[NEAR - SEAM : NEAR]
                    self.strip[end : end + SEAM] = top[NEAR : NEAR + SEAM]
                    self.hidden.remove(end)
        half = self.strip.shape[1] // 2, len(self.strip) // 2
        small = cv2.resize(self.strip[: 2 * half[1]], half, interpolation=cv2.INTER_AREA)
        self.small = np.pad(small, ((_EDGE, _EDGE), (0, 0)))
        self.page, self.left, self.blur = page, column.x < 0, blur
        self.known = dict[tuple[int, int], list[tuple[float, Name]]]()
        self.gaps = any(it.kind in APART for it in self.names)
        self.drawn_anew = kind_of(column.part) not in ("gesture", "support")  # on each staff

    def pieces(self) -> Iterator[Piece]:
        """Yield signs, upwards, and then pieces of ink that are none."""
        found = self._cut([])
        poor = [it for it in found if it.worth < _POOR * (it.foot - it.top)]
        if poor:
            base, quarter = len(self.strip) - BELOW, self.page.rows / 4
            quarters = np.rint(base - np.arange(base / quarter) * quarter).astype(int).tolist()
            around, near = round(_AROUND * quarter), np.zeros(len(self.strip), bool)
            for it in poor:
                near[max(it.top - around, 0) : it.foot + around] = True
            found = self._cut([it for it in quarters if near[it]])
        unknown = list[Piece]()
        for it in found:
            if it.name:
                yield self._settled(it.top, it.foot, it.name)
            elif unknown and unknown[-1].top == it.foot:
                unknown[-1] = replace(unknown[-1], top=it.top)
            else:
                unknown.append(Piece(it.top, it.foot, None, 0.0))
        yield from (it for it in unknown if it.foot - it.top >= _LOW)

    def _cut(self, more: list[int]) -> list[_Candidate]:
        """Return pieces of ink, upwards, cut so that they are worth most.

        There may be cuts at so many rows `more`. Pieces of nearly the best ways to cut it are
        looked at more closely, and the best is chosen once more.
        """
        places, candidates = self.places(more), list[_Candidate]()
        for end, (above, foot) in enumerate(pairwise(places), 1):
            cost = _SKIP * (foot.row - above.row) if above.inked else 0.0
            candidates.append(_Candidate(above.row, foot.row, None, 0.0, cost))
            whole = True
            near = places[max(end - _MOST, 0) : end]
            for top in near[::-1] if above.inked else ():
                whole &= top.inked
                if not (whole or self.gaps):
                    break
                if top.inked:
                    worth, name = self.named(top.row, foot.row, whole=whole)
                    if name:
                        cost = _COST + top.seam
                        if name.kind not in APART:
                            low, high = top.row + SEAM, foot.row - SEAM
                            gaps = [it.gap for it in near if low < it.row < high]
                            cost += _GAP * worth * max(gaps, default=0.0)
                        candidates.append(_Candidate(top.row, foot.row, name, worth, cost))
        if not candidates:
            return []
        close = list[_Candidate]()
        for it in _near_best(candidates, _MARGIN):
            if it.name:
                worth, name = self.closely(it.top, it.foot)
                it = it._replace(worth=worth, name=name)
            close.append(it)
        inked = {it.row for it in places if it.inked}
        return [it for it in _best(close)[::-1] if it.top in inked]

    def outlined(self) -> Iterator[Piece]:
        """Yield signs in another style than ours, upwards, and pieces of ink that are none."""
        kind = self.names[0].kind
        for top, foot in reversed(runs(self.strip[:, 2:-2].max(axis=1) > _INK)):
            found: tuple[Name | None, float] = None, 0.0
            if Name(kind, "place", "low") in self.names:
                found = named(self.strip[top:foot], kind, left=self.left)
            yield Piece(top, foot, *found)

    def places(self, more: Sequence[int] = ()) -> list[_Place]:
        """Return where signs may begin or end, also at so many rows `more`."""
        rows = self.strip[:, 2:-2].max(axis=1)
        stroke = erf(STROKE * UNIT / 2 / (self.blur * sqrt(2)))  # darkness of a blurred one
        places = list[_Place]()
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
            taken = {it + by for it in cuts for by in range(-(SIZE // 5), SIZE // 5 + 1)}
            cuts |= {it for it in more if ends[0] < it < ends[1] and it not in taken}
            inside = [_Place(it, True, *self._seam(rows, it)) for it in sorted(cuts)]
            places += [_Place(top, True), *inside, _Place(foot)]
        return places

    def _seam(self, rows: Floats, row: int) -> tuple[float, float]:
        """Return what it costs that signs meet at a row, and how surely a gap is seen there.

        By how dark rows (H,) are around it.
        """
        if self.drawn_anew and any(abs(it - row) <= SEAM for it in self.page.ends):
            return _GOES_ON, 0.0
        if any(abs(it - row) <= SEAM for it in self.hidden):
            return 0.0, 0.0
        sides = min(rows[row - 6 : row - 1].max(), rows[row + 2 : row + 7].max())
        gap = float(rows[row - 2 : row + 3].min() / max(sides, 0.01))
        none, seen = (float(np.clip(it, 0, 1)) for it in ((gap - 0.8) / 0.2, (0.6 - gap) / 0.3))
        return _SEAM * none, seen

    def named(self, top: int, foot: int, *, whole: bool) -> tuple[float, Name | None]:
        """Return the sign that a piece is most like, and its worth: more, the higher and surer."""
        if (top, foot) not in self.known:
            self.known[top, foot] = self._named(top, foot, whole=whole)
        known = self.known[top, foot]
        return known[0] if known else (0.0, None)

    def closely(self, top: int, foot: int) -> tuple[float, Name]:
        """Return the same of a piece that is like a sign, where it is not made small."""
        names = [it for _, it in self.known[top, foot]]
        values = [self.fitted(top, foot, it, self.blur, (-2, 0, 1))[0] for it in names]
        value = max(values)
        return _worth(value, foot - top), names[values.index(value)]

    def _named(self, top: int, foot: int, *, whole: bool) -> list[tuple[float, Name]]:
        """Return the few signs that a piece is most like where both are made small, best first."""
        tall = (foot - top) / SIZE
        names = tuple(it for it in self.names if (whole or it.kind in APART) and fits(it, tall))
        if not names:
            return []
        if self.blur > _CLEAR and len(names) > _LIKELY and foot - top > SIZE // 2:
            likeness = self._roughly(names, top, foot)
            # a sign that is black all over has no likeness: there is nothing in it that varies
            likeness[[it[1:3] == ("place", "low") for it in names]] = 1
            likely = np.argsort(-likeness)[:_LIKELY]
            names = tuple(names[it] for it in np.sort(likely).tolist())
        cuts = tuple(it // 2 for it in _cuts(self.page, top, foot))
        size = (foot - top + 1) // 4 * 2  # an even one: fewer images are drawn
        images = [mean_image(it, size, self.left, cuts, self.blur, COARSE) for it in names]
        known = np.array(images).reshape(len(names), -1)
        low = top // 2 + _EDGE - PAD - 1
        near = self.small[low : low + size + 2 * PAD + 2]
        windows = sliding_window_view(near, (size + 2 * PAD, COARSE + 2 * PAD))
        likeness = _alike(windows.reshape(-1, known.shape[1]), known).max(axis=0)
        if foot - top > _LONG:  # however near to each other their strokes are
            high = np.array([it.level == "high" for it in names])
            rough = np.where(high, self._roughly(names, top, foot), 0)
            likeness = np.maximum(likeness, rough)
        best = [it for it in np.argsort(-likeness)[:_FEW].tolist() if likeness[it] > _SOME]
        return [(_worth(float(likeness[it]), 2 * size), names[it]) for it in best]

    def _roughly(self, names: tuple[Name, ...], top: int, foot: int) -> Floats:
        """Return how much a piece is like signs (N,), so small that their strokes are not seen."""
        height = round(COARSE * 2 ** (round(8 * log2((foot - top) / SIZE)) / 8))
        piece = self.small[top // 2 + _EDGE : foot // 2 + _EDGE, 2:-2]
        seen = cv2.resize(piece, _ROUGH, interpolation=cv2.INTER_AREA).reshape(1, -1)
        return np.asarray(_alike(seen, _rough(names, height, self.left, self.blur))[0])

    def fitted(
        self,
        top: int,
        foot: int,
        name: Name,
        blur: float,
        taller: Sequence[int] = (-3, -2, -1, 0, 1, 2),
    ) -> tuple[float, int, int]:
        """Return how much a piece is like a sign at the best of its places: its row and height.

        It may be so many rows `taller`.
        """
        low, high = max(top - 3, 0), min(foot + 3, len(self.strip))
        piece, cuts = self.strip[low:high], _cuts(self.page, top, foot)
        best = 0.0, 0, foot - top
        for size in (foot - top + it for it in taller):
            shown = mean_image(name, size, self.left, cuts, blur)
            value, y = _like(piece, shown)
            if value > best[0] and piece[y : y + len(shown)].sum() > _PALE * shown.sum():
                best = value, low + y + PAD, size
        value, _, size = best
        if name.level == "high" and foot - top > _LONG and value:
            for by in (1 + it for it in _NEARER):
                ends = tuple(round(it * by) for it in cuts)
                drawn = image(name, round(size * by), self.left, ends, blur)
                whole = drawn.shape[1], size + 2 * PAD
                shown = np.asarray(
                    cv2.resize(drawn, whole, interpolation=cv2.INTER_AREA), np.float32
                )
                value, y = _like(piece, shown)
                if value > best[0]:
                    best = value, low + y + PAD, size
        return best

    def _settled(self, top: int, foot: int, name: Name) -> Piece:
        """Return a sign with its ends found more closely, and what is written in it."""
        value, row, size = self.fitted(top, foot, name, self.blur)
        if name.kind in DEGREES:
            name, value = self.with_degrees(row, row + size, name)
        return Piece(row, row + size, name, max(value, 0.0))

    def with_degrees(self, top: int, foot: int, name: Name) -> tuple[Name, float]:
        """Return a sign with the degrees that a piece is most like, and how much it is so."""
        near = self.strip[max(top - PAD - 1, 0) : foot + PAD + 1]
        cuts = _cuts(self.page, top, foot)

        def likeness(it: Name) -> float:
            return _like(near, image(it, foot - top, self.left, cuts, self.blur))[0]

        return _with_degrees(name, likeness)


_EDGE = 4  # rows of paper above and below a column that is made small


_ROUGH = 7, 14  # pixels, across and down, of signs that are compared roughly
_LIKELY = 8  # signs that are compared closely


@lru_cache(maxsize=256)
def _rough(names: tuple[Name, ...], height: int, left: bool, blur: float) -> Floats:
    """Return rough images of signs at a height in pixels of `COARSE`, (N, H * W)."""
    drawn = [mean_image(it, height, left, (), blur, COARSE)[PAD:-PAD, PAD:-PAD] for it in names]
    rows = [cv2.resize(it, _ROUGH, interpolation=cv2.INTER_AREA).ravel() for it in drawn]
    return np.array(rows, np.float32)


def _alike(seen: NDArray[Any], known: NDArray[Any]) -> Floats:
    """Return how much images (M, P) are like others (N, P): (M, N) correlations."""
    own, other = (it - it.mean(axis=1, keepdims=True) for it in (seen, known))
    lengths = [np.maximum(np.einsum("ij,ij->i", it, it), 1e-3) for it in (own, other)]
    return np.asarray(own @ other.T / np.sqrt(np.outer(*lengths)), np.float32)
