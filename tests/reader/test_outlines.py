"""Scores in another style than ours: narrow signs, thick lines, coarse strokes, no names."""

from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("cv2")
import cv2

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.reader.score import read_signs

THIRD = 1 / 3
CORNERS = {  # x from the left, y from the top, on the right of the staff
    "place": ((0, 0), (1, 0), (1, 1), (0, 1)),
    "right": ((0, 0), (1, 0.5), (0, 1)),
    "left": ((1, 0), (0, 0.5), (1, 1)),
    "forward": ((0, 0), (0.5, 0), (0.5, THIRD), (1, THIRD), (1, 1), (0, 1)),
    "back": ((0, 0), (1, 0), (1, 1 - THIRD), (0.5, 1 - THIRD), (0.5, 1), (0, 1)),
    "r_forward": ((0, THIRD), (1, 0), (1, 1), (0, 1)),
    "l_forward": ((0, 0), (1, THIRD), (1, 1), (0, 1)),
    "r_back": ((0, 0), (1, 0), (1, 1), (0, 1 - THIRD)),
    "l_back": ((0, 0), (1, 0), (1, 1 - THIRD), (0, 1)),
}
PITCH, BEAT = 44, 76  # pixels from column to column, and of a beat
COLUMNS = {"r_arm": 3, "l_arm": -4, "r_leg": 1, "l_leg": -2}  # places to the right of the centre


def drawn(signs: list[tuple[str, str, str, int, int]], beats: int) -> NDArray[np.uint8]:
    """Return a staff, (H, W) grey, of signs: part, direction, level, start and end in beats."""
    image = np.full((beats * BEAT + 120, 12 * PITCH), 255, np.uint8)
    centre, base = 6 * PITCH, beats * BEAT + 40
    for x in (-2, 0, 2):
        cv2.line(image, (centre + x * PITCH, 40), (centre + x * PITCH, base), 0, 2)
    for y in (40, base, base + 6):
        cv2.line(image, (centre - 2 * PITCH, y), (centre + 2 * PITCH, y), 0, 2)
    for beat in range(1, beats):
        cv2.line(image, (centre - 5, base - beat * BEAT), (centre + 5, base - beat * BEAT), 0, 2)
    for part, way, level, start, end in signs:
        left, wide, high = centre + COLUMNS[part] * PITCH + 7, PITCH - 14, (end - start) * BEAT - 8
        turned = COLUMNS[part] < 0 and way in ("forward", "back")
        corners = np.array(
            [
                (left + (1 - x if turned else x) * wide, base - end * BEAT + 4 + y * high)
                for x, y in CORNERS[way]
            ]
        )
        shape = np.zeros_like(image)
        cv2.fillPoly(shape, [corners.round().astype(np.int32)], 255)
        ink = np.zeros_like(image)
        if level == "high":
            for y in range(-PITCH, image.shape[0], 20):
                cv2.line(ink, (left, y + wide), (left + wide, y), 255, 2)
        elif level == "mid":
            middle = corners.mean(axis=0) if way in ("left", "right") else corners[0]
            x = middle[0] if way in ("left", "right") else left + wide / 2
            cv2.circle(ink, (round(x), round(base - end * BEAT + 4 + high / 2)), 4, 255, -1)
        else:
            ink[:] = 255
        image[(ink > 0) & (shape > 0)] = 0
        cv2.polylines(image, [corners.round().astype(np.int32)], True, 0, 2)
    return image


def test_signs_in_another_style_are_read_by_their_outlines() -> None:
    signs, ends = list[tuple[str, str, str, int, int]](), dict.fromkeys(COLUMNS, 0)
    every = list(product(DIRECTIONS, LEVELS))
    for number, at in enumerate(np.random.default_rng(5).permutation(2 * len(every)).tolist()):
        part = list(COLUMNS)[number % len(COLUMNS)]
        length = 1 + number % 3 // 2
        signs.append((part, *every[at % len(every)], ends[part], ends[part] + length))
        ends[part] += length
    page = read_signs(drawn(signs, max(ends.values())))
    found = {(it.part, it.direction, it.level, it.start, it.end) for it in page.records}
    assert len(found & {*signs}) >= len(signs) - 2
    assert not found - {*signs}
    assert any("taken by their places" in it for it in page.notes)
