"""Damage to pictures of scores as scanners, printers and cameras do it, and where points go."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Forward = Callable[[Points], Points]
"""Where points (N, 2), x and y in pixels of the picture, come to lie on the damaged one."""


@dataclass(frozen=True, slots=True)
class Level:
    """How bad a picture gets: ranges, from the least to the most."""

    size: tuple[float, float]  # Of the picture as drawn
    angle: float  # Degrees to either side, at most
    blur: tuple[float, float]  # Pixels
    noise: tuple[float, float]  # Grey levels
    quality: int  # Of JPEG
    warp: float = 0.0  # How far the page curls, at most: a share of its height
    corners: float = 0.0  # How far corners move in perspective, at most: a share of the width
    shade: float = 1.0  # The light in the darkest corner, at least


LEVELS: dict[str, Level | None] = {
    "clean": None,
    "light": Level((0.8, 0.8), 0.4, (0.3, 0.7), (2, 8), 80),
    "hard": Level((0.6, 0.6), 1.0, (0.4, 0.8), (4, 12), 70, warp=0.002),
    "photo": Level((0.8, 1.0), 5.0, (0.5, 1.1), (3, 8), 75, 0.001, 0.04, 0.5),
}


def damaged(
    image: NDArray[np.uint8], name: str, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], Forward]:
    """Return a grey picture (H, W) as it looks at a level of damage, and where its points go."""
    import cv2

    level = LEVELS[name]
    if level is None:
        return image, lambda points: points
    size = rng.uniform(*level.size)
    border = round(rng.uniform(0.01, 0.05) * max(image.shape))
    page = cv2.copyMakeBorder(image, *[border] * 4, cv2.BORDER_CONSTANT, value=255)
    page = cv2.resize(page, None, fx=size, fy=size, interpolation=cv2.INTER_AREA)
    height, width = page.shape
    matrix, (wide, high) = _placed(width, height, level, rng)
    curl, bends = _curl(width, height, level, rng)
    out = np.stack(np.meshgrid(np.arange(wide), np.arange(high)), -1).reshape(-1, 2)
    source = curl(_through(np.linalg.inv(matrix), out.astype(np.float64)))
    x, y = source.T.reshape(2, high, wide).astype(np.float32)
    paper, ink = rng.uniform(225, 255), rng.uniform(0, 60)
    grey = ink + page.astype(np.float32) / 255 * (paper - ink)
    around = rng.uniform(60, 150) if level.corners else paper  # the table below a photograph
    grey = cv2.remap(
        grey, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_CONSTANT, borderValue=around
    )
    grey = _shaded(grey, level, rng)
    grey = cv2.GaussianBlur(grey, (0, 0), rng.uniform(*level.blur))
    grey += rng.normal(0, rng.uniform(*level.noise), grey.shape)
    flat = np.clip(grey.round(), 0, 255).astype(np.uint8)
    _, packed = cv2.imencode(".jpg", flat, [cv2.IMWRITE_JPEG_QUALITY, level.quality])
    seen = cv2.imdecode(packed, cv2.IMREAD_GRAYSCALE)

    def forward(points: Points) -> Points:
        return _through(matrix, bends((points + border + 0.5) * size - 0.5))

    return np.asarray(seen, np.uint8), forward


def _through(matrix: Points, points: Points) -> Points:
    """Return points (N, 2) moved by a homography (3, 3)."""
    moved = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return np.asarray(moved[:, :2] / moved[:, 2:])


def _placed(
    width: int, height: int, level: Level, rng: np.random.Generator
) -> tuple[Points, tuple[int, int]]:
    """Return the homography that lays a page on its picture, and that one's width and height."""
    import cv2

    angle = np.radians(rng.uniform(-level.angle, level.angle))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    middle = np.array([width, height]) / 2
    corners = np.array([(0, 0), (width, 0), (width, height), (0, height)], float)
    moved = (corners - middle) @ turn.T + middle
    moved += rng.uniform(-1, 1, (4, 2)) * level.corners * width
    if level.corners:  # all of the page is in the picture, and some of the table
        moved -= moved.min(axis=0) - rng.uniform(5, 30, 2)
        wide, high = (moved.max(axis=0) + rng.uniform(5, 30, 2)).round().astype(int).tolist()
    else:  # a scanner's glass is as large as the page
        wide, high = width, height
    matrix = cv2.getPerspectiveTransform(corners.astype(np.float32), moved.astype(np.float32))
    return matrix, (wide, high)


def _curl(
    width: int, height: int, level: Level, rng: np.random.Generator
) -> tuple[Forward, Forward]:
    """Return how a page that does not lie flat is seen, and the way back, nearly."""
    most = level.warp * height * rng.uniform(0.3, 1, 2)
    waves = rng.uniform(0.5, 1.2, 2) * 2 * np.pi / np.array([height, width])
    phases = rng.uniform(0, 2 * np.pi, 2)

    def shift(points: Points) -> Points:
        return np.asarray(most * np.sin(points[:, ::-1] * waves + phases))

    return lambda points: points + shift(points), lambda points: points - shift(points)


def _shaded(
    grey: NDArray[np.float32], level: Level, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return a picture (H, W) in light that fades to one side and to its corners."""
    y, x = (np.linspace(-1, 1, size, dtype=np.float32) for size in grey.shape)
    way, depth = rng.uniform(0, 2 * np.pi), 1 - rng.uniform(level.shade, 1)
    slope = (np.cos(way) * x + np.sin(way) * y[:, None]) / (2 * np.sqrt(2)) + 0.5
    rim = (x**2 + y[:, None] ** 2) / 2
    return np.asarray(grey * (1 - depth * (0.7 * slope + 0.3 * rim)), np.float32)
