"""Signs in another style than ours: the direction by their outline, the level by what fills it."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from lanindex.alphabet import DIRECTIONS
from lanindex.draw.picture import C, Polyline, sign
from lanindex.reader.staff import Image
from lanindex.reader.templates import SIZE, Floats, Name

_DARK = 0.4  # darkness from which on there is ink
_LIKE = 0.75  # share that an outline must have in common with a known one
_APART = 0.02  # by how much more than with the next best one
_FULL = 0.7  # share of ink in a sign of low level, at least
_STROKES = 0.2  # share of ink in a sign of high level, at least, unless it has no dot
_STROKE = 0.1  # widths of a symbol, of the outline, at most
_THIN = 0.4  # widths: what is narrower is no sign


def named(ink: Floats, kind: str, *, left: bool) -> tuple[Name | None, float]:
    """Return the sign that a piece of a column, (H, W) of darkness, is, and how sure that is.

    `kind` is gesture or support; `left` is the left of the staff.
    """
    shape = _filled((ink > _DARK).astype(np.uint8))
    x, y, width, height = cv2.boundingRect(shape)
    if min(width, height) < _THIN * SIZE:
        return None, 0.0
    shape = shape[y : y + height, x : x + width]
    found = sorted(
        (
            (max(_shared(shape, it) for it in _shapes(way, height, width, left)), way)
            for way in DIRECTIONS
        ),
        reverse=True,
    )
    (best, way), (second, _) = found[:2]
    level = _level(ink[y : y + height, x : x + width], shape)
    if best < max(_LIKE, second + _APART) or level is None:
        return None, 0.0
    return Name(kind, way, level), best


def _shared(one: Image, other: Image) -> float:
    """Return the share of two shapes, (H, W), that they have in common."""
    return float((one & other).sum() / (one | other).sum())


def _filled(ink: Image) -> Image:
    """Return the largest shape of ink, (H, W) of 0 and 1, with what it encloses."""
    padded = np.pad(cv2.morphologyEx(ink, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)), 1)
    outside = padded.copy()
    cv2.floodFill(outside, None, (0, 0), 1)
    full = np.where(outside == 0, 1, padded)[1:-1, 1:-1].astype(np.uint8)
    solid = cv2.morphologyEx(full, cv2.MORPH_OPEN, np.ones((1, 4), np.uint8))  # no lines beside
    _, parts, sizes, _ = cv2.connectedComponentsWithStats(solid)
    if len(sizes) < 2:
        return np.zeros_like(ink)
    largest = 1 + int(sizes[1:, cv2.CC_STAT_AREA].argmax())
    return np.asarray(parts == largest, np.uint8)


def _level(ink: Floats, shape: Image) -> str | None:
    """Return the level by the ink (H, W) within a shape: full, strokes all over, or a dot."""
    edge = 2 * round(_STROKE * SIZE) + 1
    within = cv2.erode(np.pad(shape, 1), np.ones((edge, edge), np.uint8))[1:-1, 1:-1] > 0
    if not within.any():
        return None
    dark = (ink > _DARK) & within
    share = dark.sum() / within.sum()
    if share > _FULL:
        return "low"
    _, _, boxes, _ = cv2.connectedComponentsWithStats(dark.astype(np.uint8), connectivity=4)
    if share < _STROKES and any(_is_dot(*it) for it in boxes[1:].tolist()):
        return "mid"
    spread = [dark.any(axis=at).sum() / within.any(axis=at).sum() for at in (0, 1)]
    return "high" if min(spread) > 0.5 else None


def _is_dot(_: int, __: int, width: int, height: int, area: int) -> bool:
    """Return whether a piece of ink is a dot, by its box and its pixels."""
    low, high = 0.1 * SIZE, 0.45 * SIZE
    return low < min(width, height) and max(width, height) < high and area > 0.55 * width * height


@lru_cache(maxsize=1024)
def _shapes(way: str, height: int, width: int, left: bool) -> list[Image]:
    """Return how a direction fills a box, (H, W) of 0 and 1, with notches of two sizes."""
    found = []
    for high in (C, C * height // width):
        (mark,) = sign(0, high, way, "low", high, left=left)
        assert isinstance(mark, Polyline)
        points = np.array(mark.lines[0], float) + np.array([0, high])
        corners = (points * ((width - 1) / C, (height - 1) / high)).round().astype(np.int32)
        shape = np.zeros((height, width), np.uint8)
        found.append(np.asarray(cv2.fillPoly(shape, [corners], 1), np.uint8))
    return found
