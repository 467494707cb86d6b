"""Marks that stand across the columns of others: flights, and bows from hands to what they touch.

They are found before columns are read, by filters along where their ink would be, and taken out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import CONTACTS, FEET, TOUCHED, amounts_of, kind_of
from lanindex.draw.picture import BOW, GAP, C
from lanindex.draw.staff import DOUBLE, PITCH, staff_columns
from lanindex.reader.layout import BELOW, NEAR, Layout, Piece
from lanindex.reader.names import WIDEST, Column
from lanindex.reader.staff import runs
from lanindex.reader.templates import SEAM, SIZE, STROKE, UNIT, Floats, Name

_BESIDE = 5  # pixels on either side of a line of a flight that are looked at
_FLIGHT = 11  # rows over which its darkness is averaged
_INK = 0.5  # of a line, 1: as dark as it is drawn
_LEAST = 8  # rows of a flight
_JUMP = Name("jump", "place", amount=FEET.index("unseen"))  # until it is known what is around it


def flights(
    whole: Floats, ink: Floats, turns: Sequence[tuple[int, int]], blur: float
) -> Iterator[tuple[Column, Piece]]:
    """Yield the flights in ink (H, W), whole, and take them out of that without the turns.

    Signs on either side end close to where the lines of a flight are. So what is dark there is
    taken apart: into a line, and what ends as far away as signs do. The sides of turns across the
    centre line, rows half-open, lie where the lines do: a flight is longer than these.
    """
    dark = list[NDArray[Any]]()
    for x in (-PITCH * UNIT, PITCH * UNIT):
        first = _pixel(x) - _BESIDE
        away = np.arange(first, first + 2 * _BESIDE + 1) + 0.5 - WIDEST * SIZE - x
        line = np.dot(whole[:, first : first + len(away)], _line(away, blur))
        dark.append(cv2.blur(line[:, None], (1, _FLIGHT))[:, 0])
    both = np.minimum(*dark)
    place = Column("jump", 0.0, inside=True, half=PITCH / C)
    free = np.ones(len(ink), bool)
    for top, foot in turns:
        free[top:foot] = False
    for top, foot in runs(both[: len(ink) - BELOW] > _INK):
        if free[top:foot].sum() >= _LEAST:
            for x in (-PITCH * UNIT, PITCH * UNIT):
                _bridge(ink[top - 2 : foot + 2].T, _pixel(x), 2)
            sure = min(float(np.median(both[top:foot])), 1.0)
            yield place, Piece(top - GAP * UNIT, foot + GAP * UNIT, _JUMP, sure)


def _pixel(x: float) -> int:
    """Return the column of ink in which a place is, pixels from the centre line."""
    return int(x + WIDEST * SIZE)


def _line(away: NDArray[Any], blur: float) -> Floats:
    """Return weights (P,) of pixels so far away from a line that tell how dark it is."""
    fine = np.arange(-16, 16, 0.05)
    near, half = (PITCH - C) / 2 * UNIT, STROKE / 2 * UNIT
    marks = [np.abs(fine - at) < half for at in (0, -near, near)]
    marks += [fine < -near, fine > near]
    soft = np.exp(-(np.arange(-8, 8, 0.05) ** 2) / (2 * (blur**2 + 0.1)))  # and that of pixels
    known = [np.interp(away, fine, np.convolve(it, soft / soft.sum(), "same")) for it in marks]
    return np.asarray(np.linalg.pinv(np.array(known).T)[0], np.float32)


def _bridge(ink: Floats, row: int | NDArray[np.intp], half: int) -> None:
    """Replace what is so near to a row of ink (H, W), or one of each column, by what is beyond."""
    columns = np.arange(ink.shape[1])
    above, below = ink[row - half - 1, columns], ink[row + half + 1, columns]
    for at in range(-half, half + 1):
        share = np.float32((at + half + 1) / (2 * half + 2))
        between = above * (1 - share) + below * share
        ink[row + at, columns] = np.minimum(ink[row + at, columns], between)


_SEEN = 4  # rows above and below a bow that are lighter
_BLACK = 0.3  # darkness from which on a bow may be hidden
_HIDDEN = 0.6  # what a piece counts where it is
_GAPS = 5  # how many times a piece between two columns counts: nothing else crosses there
_ENDS = 0.7  # of a bow's likeness, that of either end
_ALIKE = 0.76  # likeness from which on it is a bow


def touches(page: Layout, ink: Floats, blur: float) -> Iterator[tuple[Column, Piece]]:
    """Yield the touches of a page, each where it begins, and take their bows out of its ink."""
    columns = staff_columns(it.part for it in page.columns)
    told: dict[tuple[int, int], list[tuple[str, int]]] = {}
    for number, thing in enumerate(TOUCHED):
        for part in CONTACTS:
            if kind_of(part) == "touch" and thing in amounts_of(part):
                told.setdefault(columns.touched(part, thing), []).append((part, number))
    bows = [_Bow(*ends, page, blur) for ends in told]
    base = len(ink) - BELOW
    seen = _seen(page, ink, [*page.lines, base + _SECOND, _SECOND])
    found = list[tuple[float, int, _Bow]]()
    for it in bows:
        likeness = it.likeness(ink, seen)
        found += [(likeness[row], row, it) for row in range(2 * _SEEN, base + _SEEN)]
        for end, near in zip(page.ends, page.bases, strict=True):
            likeness = it.likeness(near, _seen(page, near, [NEAR]))
            found += [(likeness[NEAR + at], end + at, it) for at in range(-_SEEN, _SEEN)]
    taken = list[tuple[int, _Bow]]()
    for alike, row, it in sorted(found, key=lambda it: -it[0]):
        if alike < _ALIKE:
            break
        if any(abs(row - other) < SIZE / 2 and it.meets(one) for other, one in taken):
            continue
        taken.append((row, it))
        # its ends were drawn over where a staff ends
        it.erase(ink, row, SEAM * (min(abs(row - end) for end in (*page.ends, -SIZE)) < SEAM))
        whose = told[it.ends]
        place = Column(whose[0][0], sum(it.ends) / 2 / C, inside=False, half=it.wide / 2 / C)
        yield place, Piece(row, row, Name("touch", amount=whose[0][1]), alike / len(whose))


_SECOND = round(DOUBLE * UNIT)  # rows from a line to the second of a double one


def _seen(page: Layout, ink: Floats, lines: list[int]) -> NDArray[np.bool_]:
    """Return where ink (H, W) is seen: not where lines of a staff were."""
    inner, seen = SIZE / page.unit, np.ones(ink.shape, bool)
    across = np.arange(ink.shape[1]) + 0.5 - WIDEST * SIZE
    for row in lines:
        seen[max(row - 2, 0) : max(row + 2, 0), np.abs(across) < inner + 2] = False
    seen[:, np.abs(np.abs(across) - inner) < 1.7] = False
    seen[:, np.abs(across) < 1.7] = False
    return seen


class _Bow:
    """A bow between two places, units from the centre line."""

    def __init__(self, start: int, stop: int, page: Layout, blur: float) -> None:
        self.ends, self.wide = (start, stop), stop - start
        self.least = 0.2 * min(0.55 / blur, 0.6)  # by which it is darker than what is around it
        self.thick = 2 + round(blur)  # pixels to either side that are taken out
        middles = np.arange(2 * WIDEST * SIZE) + 0.5 - WIDEST * SIZE
        self.xs = np.flatnonzero((middles >= start * UNIT) & (middles <= stop * UNIT))
        points = np.linspace(0, 1, 9)  # it is drawn in eight straight lines
        share = (middles[self.xs] / UNIT - start) / self.wide
        depth = np.interp(share, points, BOW * np.sin(pi * points)) - BOW / 2
        self.down = np.round(depth * UNIT).astype(np.intp)
        sides = np.array([it.x * C + side for it in page.columns for side in (-PITCH, PITCH)])
        # borders of columns lie half a pitch from their middles
        borders = (sides + np.array([PITCH / 2, -PITCH / 2] * len(page.columns))) * UNIT
        away = np.abs(middles[self.xs][:, None] - borders).min(axis=1)
        self.weights = np.where(away < (PITCH - C) / 2 * UNIT - 0.7, _GAPS, 1.0)

    def meets(self, other: _Bow) -> bool:
        """Return whether two bows at one height share most of the shorter one."""
        shared = min(self.ends[1], other.ends[1]) - max(self.ends[0], other.ends[0])
        return shared > min(self.wide, other.wide) / 2

    def likeness(self, ink: Floats, seen: NDArray[np.bool_]) -> list[float]:
        """Return how much of it there is if it begins at rows (H,) of ink (H, W)."""
        rows = np.clip(np.arange(len(ink))[:, None] + self.down, 0, len(ink) - 1)
        along, known = ink[rows, self.xs], seen[rows, self.xs]
        line = cv2.dilate(along, np.ones((3, 1), np.uint8))
        edge = np.zeros((_SEEN, len(self.xs)), np.float32)
        around = np.maximum(np.vstack([edge, along[:-_SEEN]]), np.vstack([along[_SEEN:], edge]))
        there = line - around > self.least
        black = ~there & known & (line > _BLACK)
        quarter = max(len(self.xs) // 4, 1)
        alike = [
            (there[:, part] + _HIDDEN * black[:, part])
            @ self.weights[part]
            / ((there | known)[:, part] @ self.weights[part] + 0.05 * self.weights[part].sum())
            for part in (slice(None), slice(quarter), slice(-quarter, None))
        ]
        return list(np.minimum(alike[0], np.minimum(*alike[1:]) / _ENDS).tolist())

    def erase(self, ink: Floats, row: int, more: int) -> None:
        """Take it, and some more above and below, out of ink (H, W) where it begins at a row."""
        edge = self.thick + more + 1
        rows = np.clip(self.down + row, edge, len(ink) - edge - 1)
        near = ink[:, self.xs]
        _bridge(near, rows, self.thick + more)
        ink[:, self.xs] = near
