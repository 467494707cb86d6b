"""The columns of a page's staves, by the names below them or by their usual places.

Where a column lies depends on those between it and the centre line, so all names are read together:
of all ways to lay columns out the one whose names are most like what is printed. Where nothing is
printed, columns are in the places that are usual in Labanotation: supports and legs between the
staff's lines; the torso, the arms and the head beside them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import dist

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import kind_of
from lanindex.data import shipped
from lanindex.draw import svg
from lanindex.draw.picture import PIXEL, C, Label, Picture
from lanindex.draw.staff import MARGIN, NAME, NAMES, NUMBERS, PITCH, PITCHES, START, name_of
from lanindex.errors import CaptureError
from lanindex.reader.staff import Staff, runs

Floats = NDArray[np.float32]

SCALE = 0.3
"""Pixels of a unit where names are compared."""

WIDEST = 25
"""Widths of a symbol on either side of the centre line that are looked at: our widest score's."""

_COLUMNS = shipped("draw/signs.toml")["columns"]
_ALWAYS = {"r_support", "r_leg"}  # they and their twins have columns, named or not
_DARK = 0.7  # of names, 1: black
_SURE = 0.25  # share of a name's ink that must be told better by it than by paper
_UNLIKE = 0.86  # of the likeness of other names on the page: below it, one is another name
_WIDEST = WIDEST * C  # units
_SHIFT = 5  # pixels by which a name may lie elsewhere
_ASKEW = 0.08  # by how much a page that was made flat may be higher or lower than wide
_BLURS = (0.5, 0.8, 1.1, 1.5)  # pixels of the page by which names may be blurred
_INK = 150  # brightness below which there is ink
_HIGH = 0.6  # widths that the highest sign of a column is, at least; numbers of bars are lower


@dataclass(frozen=True, slots=True)
class Column:
    """A column of all staves of a page, or the place of what stands across some."""

    part: str
    x: float  # Its middle, from the centre line, widths of a symbol
    inside: bool  # Whether it lies between the outer lines
    half: float = 0.5  # From its middle to its sides, widths of a symbol


def columns(staves: Sequence[Staff]) -> tuple[float, list[Column], bool]:
    """Return the width of a symbol by the distance of the outer lines, and the columns.

    Parameters
    ----------
    staves : sequence of Staff
        Of one page.

    Returns
    -------
    unit : float
    found : list of Column
    named : bool
        Whether the columns have names. Where nothing is printed below the staves, they are those
        in the usual places.

    Raises
    ------
    CaptureError
        If there are names, but they cannot be read.
    """
    best = (0.0, 0.0, list[Column]())
    room = _pitch(staves)
    for inner in _inners(staves):
        unit = float(np.median([it.inner for it in staves])) / inner  # pixels
        strips = [names_below(it, it.inner / inner) for it in staves]
        for blur in _BLURS:
            worth, found = _read(strips, blur / unit * SCALE, inner, room * inner)
            best = max(best, (worth, C / inner, found), key=lambda it: it[0])
    if best[2]:
        return best[1], best[2], True
    inner = 2 * PITCH
    short = _SURE * float(_name(name_of("r_leg"), _BLURS[1]).sum())
    if any(float(names_below(it, it.inner / inner).clip(0, 1).sum()) > short for it in staves):
        remedy = "Give it a sharper picture, or one that ends below the staves."
        raise CaptureError("no names of columns that can be read below its staves", remedy=remedy)
    return C / inner, _usual(staves), False


def _usual(staves: Sequence[Staff]) -> list[Column]:
    """Return columns in their usual places, those beside the staff as far as they have ink."""
    right, left = ([at for at in range(2, 6) if _has_ink(staves, side, at)] for side in (1, -1))
    # only arms stand on the left of the staff; the torso is nearest to it, if they leave that free
    arms = [at for at in left if at > 2][-2:] or left or [3]
    limbs = ["arm"] if len(arms) == 1 else ["upper_arm", "forearm"]
    found = [(2, 1, "torso")] * (2 not in arms)
    found += [(at, 1, "head") for at in right if at > max(arms)][:1]
    for at, limb in zip((0, 1, *arms), ("support", "leg", *limbs), strict=True):
        found += [(at, 1, f"r_{limb}"), (at, -1, f"l_{limb}")]
    return [Column(part, side * (at + 0.5) * PITCH / C, at < 2) for at, side, part in found]


def _has_ink(staves: Sequence[Staff], side: int, at: int) -> bool:
    """Return whether signs stand beside a staff so many columns from its centre line."""
    for staff in staves:
        unit = staff.inner / (2 * PITCH)
        middle, half = staff.centre + side * (at + 0.5) * PITCH * unit, 0.3 * C * unit
        first, last = round(middle - half), round(middle + half)
        if first >= 0 and last < staff.image.shape[1]:
            column = staff.image[round(staff.top) : round(staff.foot), first:last]
            inked = runs(column.min(axis=1) < _INK)
            if any(foot - top > _HIGH * C * unit for top, foot in inked):
                return True
    return False


def _inners(staves: Sequence[Staff]) -> list[int]:
    """Return from the centre line to the outer ones, units: as columns may fill it.

    A starting position tells how high a unit is, nearly: a photograph is higher or lower.
    """
    every = [PITCH * count + C * narrow for count in range(2, 7) for narrow in (0, 1)]
    below = [(it.foot - it.base) / it.inner for it in staves if it.foot - it.base > it.inner / 4]
    wanted = (MARGIN + START) / below[0] if below else 0.0
    near = [it for it in every if abs(it - wanted) < _ASKEW * wanted]
    return near or every


def names_below(staff: Staff, unit: float) -> Floats:
    """Return the ink of the names below a staff, `SCALE` pixels a unit: (H, W)."""
    down = (np.arange(round(NAMES * SCALE) + 2 * _SHIFT) - _SHIFT + 0.5) / SCALE + MARGIN
    across = (np.arange(round(2 * _WIDEST * SCALE)) + 0.5) / SCALE - _WIDEST
    x, y = np.meshgrid(
        (staff.centre + across * unit).astype(np.float32),
        (staff.foot + down * unit).astype(np.float32),
    )
    ink = (255 - staff.image.astype(np.float32)) / np.float32(255)
    seen = cv2.remap(ink, x, y, cv2.INTER_CUBIC, borderValue=0)
    wide = cv2.morphologyEx(seen, cv2.MORPH_OPEN, np.ones((27, 27), np.uint8))  # no writing
    return np.asarray(seen - wide, np.float32)


def _pitch(staves: Sequence[Staff]) -> float:
    """Return from one centre line to the next, by the distance of the outer lines; 0: one staff."""
    found = list[float]()
    for one, other in pairwise(staves):
        left, right = (one.on_page(one.centre + side * one.inner, one.base) for side in (-1, 1))
        centres = [it.on_page(it.centre, it.base) for it in (one, other)]
        found.append(2 * dist(*centres) / dist(left, right))
    return float(np.median(found)) if found else 0.0


def _read(
    strips: list[Floats], blur: float, inner: int, pitch: float
) -> tuple[float, list[Column]]:
    """Return how well names in images (H, W) are told by columns, and these columns.

    Those of two staves fill the room between these, so that names of the next one are not ours.
    """
    known = dict[tuple[str, int], float]()

    def worth(part: str, x: int) -> float:
        if (part, x) not in known:
            each = [_likeness(it, part, x, blur) if part else (0.0, 1.0) for it in strips]
            told, least = np.mean(each, axis=0).tolist()
            known[part, x] = told if told > least else -1.0
        return known[part, x]

    # by how far columns reach from the centre: how well they are told, and which they are
    best: dict[int, tuple[float, tuple[tuple[str, int], ...]]] = {0: (0.0, ())}
    for where in ("inside", "outside"):
        for right, left in _COLUMNS[where]:
            wide = PITCHES.get(kind_of(right), PITCH) if right else PITCH
            reached = {} if right in _ALWAYS else dict(best)
            for at, (value, chosen) in best.items():
                if at + wide > (inner if where == "inside" else _WIDEST - C):
                    continue
                middle = at + wide // 2
                sides = [(right, middle), (left, -middle)]
                named = [(part, x) for part, x in sides if worth(part, x) > 0]
                if named or right in _ALWAYS:
                    now = value + sum(worth(*it) for it in named)
                    if now >= reached.get(at + wide, (-1.0, ()))[0]:
                        reached[at + wide] = now, (*chosen, *named)
            best = reached
        if where == "inside":
            best = {at: it for at, it in best.items() if at == inner}
    if not best:
        return 0.0, []

    def fills(chosen: tuple[tuple[str, int], ...]) -> bool:
        reach = [
            max([inner, *(abs(x) + C // 2 for _, x in chosen if x * side > 0)]) for side in (-1, 1)
        ]
        return abs(sum(reach) + NUMBERS + MARGIN - pitch) < PITCH / 2

    fitting = [it for it in best.values() if pitch and fills(it[1])]
    value, chosen = max(fitting or best.values(), key=lambda it: it[0])
    return value, [Column(part, x / C, abs(x) < inner) for part, x in chosen]


def _likeness(strip: Floats, part: str, x: int, blur: float) -> tuple[float, float]:
    """Return by how much ink is explained better by a name in a place than by paper.

    And by how much it is, at least, if the name is there.
    """
    name = _name(name_of(part), round(blur, 1))
    left = round((x + NAME // 3 + _WIDEST) * SCALE) - _ASCENT
    height, width = name.shape
    place = strip[: height + 2 * _SHIFT, max(left - _SHIFT, 0) : left + width + _SHIFT]
    all_ = _DARK**2 * float((name**2).sum())
    if place.shape[0] < height or place.shape[1] < width:
        return 0.0, all_
    meet = float(cv2.matchTemplate(place, name, cv2.TM_CCORR).max())
    return 2 * _DARK * meet - all_, _SURE * all_


def unlike(staves: Sequence[Staff], unit: float, columns: Sequence[Column]) -> Iterator[Column]:
    """Yield columns whose names are much less like what is printed than those of the others.

    `unit`: as `columns` returns it.
    """
    below = [names_below(it, unit * it.inner / C) for it in staves]
    same = [max(_sameness(below, it, blur) for blur in _BLURS) for it in columns]
    usual = float(np.median(same))
    yield from (it for it, own in zip(columns, same, strict=True) if own < _UNLIKE * usual)


def _sameness(below: Sequence[Floats], column: Column, blur: float) -> float:
    """Return how much a name is all that is printed in its place, 0 to 1: the mean of images."""
    name = _name(name_of(column.part), blur)
    left = round((column.x * C + NAME // 3 + _WIDEST) * SCALE) - _ASCENT
    found = list[float]()
    for ink in below:
        place = ink[:, max(left - _SHIFT, 0) : left + name.shape[1] + _SHIFT]
        rows = max(len(ink) - 2 * _SHIFT - len(name), 0)  # of paper below a name
        whole = np.pad(name, ((0, rows), (0, 0)))
        meet = cv2.matchTemplate(place, whole, cv2.TM_CCORR)
        energy = cv2.matchTemplate(place**2, np.ones_like(whole), cv2.TM_CCORR)
        norm = np.sqrt(np.maximum(energy, 1e-6) * float((whole**2).sum()))
        found.append(float((meet / norm).max()))
    return float(np.mean(found))


_ASCENT = 20  # pixels left of a name's line of writing


@lru_cache(maxsize=1024)
def _name(text: str, blur: float) -> Floats:
    """Return a name as it is printed below a column, from where it ends: (H, W) of darkness."""
    wide = round((0.75 * len(text) + 1) * NAME)
    label = Label(round(_ASCENT / SCALE), 0, text, NAME, "end", turned=True)
    picture = Picture(round((_ASCENT + 10) / SCALE), wide, "", "", (label,))
    drawn = svg.image(svg.write(picture, scale=SCALE * PIXEL * 4, ink=svg.INK))
    large = cv2.imdecode(np.frombuffer(drawn, np.uint8), cv2.IMREAD_GRAYSCALE)
    small = cv2.resize(np.asarray(large), None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    ink = 1 - small.astype(np.float32) / np.float32(255)
    last = int(np.flatnonzero(ink.max(axis=1) > 0.1)[-1])
    return np.asarray(cv2.GaussianBlur(ink[: last + 3], (0, 0), blur), np.float32)
