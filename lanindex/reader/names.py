"""The parts of columns, by the names that are printed below them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.data import shipped
from lanindex.draw import svg
from lanindex.draw.picture import PIXEL, C, Label, Picture
from lanindex.draw.staff import name_of
from lanindex.reader.signs import SIZE, Column, Page
from lanindex.reader.staff import Staff

_COLUMNS = shipped("draw/signs.toml")["columns"]
_NAMED = 0.5  # likeness of a name below a column, at least
_UNNAMED = {True: ("support", "leg"), False: ("arm", "hand")}
"""Columns whose names cannot be read, outwards: inside of the staff (True), and outside."""


def named(staves: Sequence[Staff], page: Page) -> list[tuple[Column, str]]:
    """Return the part of each column: as the name below says, or else by its place."""
    found = list[tuple[Column, str]]()
    taken = set[str]()
    for column in page.columns:
        pairs = _COLUMNS["inside" if column.inside else "outside"]
        own = [pair[column.number < 0] for pair in pairs]
        by_name = {name_of(part): part for part in own if part and part not in taken}
        name, likeness = _name(staves[0], page, column, tuple(by_name))
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
