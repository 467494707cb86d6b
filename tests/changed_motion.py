"""Motions changed in ways that METHOD's laws speak of, and what the change does to symbols."""

from dataclasses import replace

import numpy as np
from rapidfuzz.distance import Levenshtein

from lanindex.alphabet import (
    DIRECTION_CODES,
    DIRECTIONS,
    JOINTS,
    KINDS,
    MIRRORED,
    kind_of,
    mirrored_part,
)
from lanindex.model import Motion, Score, Symbol

LIMBS = ("r_arm", "l_arm", "r_leg", "l_leg")


def turned(motion: Motion, degrees: float) -> Motion:
    """Return the whole capture turned about the vertical."""

    def turn(vectors: np.ndarray) -> np.ndarray:
        angle = np.radians(degrees)
        x, y, z = np.moveaxis(vectors.astype(np.float64), 2, 0)
        front, side = np.cos(angle) * x + np.sin(angle) * z, np.cos(angle) * z - np.sin(angle) * x
        return np.stack((front, y, side), axis=2).astype(np.float32)

    axes = {joint: turn(own) for joint, own in motion.axes.items()}
    return replace(motion, positions=turn(motion.positions), axes=axes)


def moved(motion: Motion, way: tuple[float, float, float]) -> Motion:
    """Return the whole capture moved by so many mm."""
    return replace(motion, positions=motion.positions + np.asarray(way, np.float32))


def scaled(motion: Motion, factor: float) -> Motion:
    return replace(motion, positions=motion.positions * np.float32(factor))


def mirrored(motion: Motion) -> Motion:
    """Return the capture as a mirror shows it: left and right change their roles."""
    swapped = [
        JOINTS.index({"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:]) for name in JOINTS
    ]
    skeleton = replace(motion.skeleton, body=motion.skeleton.body[swapped])
    mirror = np.array([1, 1, -1], np.float32)
    axes = {}
    for joint, own in motion.axes.items():
        side = {"R": "L", "L": "R"}.get(joint[0], "")
        sign = 1 if side else np.array([[-1], [1]], np.float32)  # of a head its right
        axes[side + joint[1:] if side else joint] = own * sign * mirror
    return replace(motion, skeleton=skeleton, positions=motion.positions * mirror, axes=axes)


def thinned(motion: Motion, step: int) -> Motion:
    """Return every `step`-th frame; the first of the movement stands in for those before it."""

    def thin(values: np.ndarray) -> np.ndarray:
        kept = values[::step].copy()
        kept[: -(-motion.first // step)] = values[motion.first]
        return kept

    axes = {joint: thin(own) for joint, own in motion.axes.items()}
    places = thin(motion.positions)
    return replace(motion, rate=motion.rate / step, positions=places, first=0, axes=axes)


def noisy(motion: Motion, size: float, seed: int = 0) -> Motion:
    """Return every coordinate of every joint with noise of a standard deviation of `size` mm."""
    noise = np.random.default_rng(seed).normal(0.0, size, motion.positions.shape)
    return replace(motion, positions=(motion.positions + noise).astype(np.float32))


def shown(score: Score, part: str) -> list[tuple[str, str]]:
    """Return direction and level of a part's symbols, the starting position first."""
    return [(s.direction, s.level) for s in score.symbols(part) if not s.passing]


def edits(score: Score, other: Score, part: str) -> tuple[int, int]:
    """Return how many edits lead from one track to the other, and the first's symbols."""
    one = shown(score, part)
    return Levenshtein.distance(one, shown(other, part)), len(one)


Row = tuple[str, str, int, int, bool, int]


def row(symbol: Symbol) -> Row:
    return (
        symbol.direction,
        symbol.level or (symbol.words.split()[-1] if KINDS[kind_of(symbol.part)].amounts else None),
        symbol.span.start,
        symbol.span.stop,
        symbol.passing,
        symbol.swings,
    )


def rows(score: Score) -> dict[str, list[Row]]:
    """Return all that a law says does not change."""
    return {part: [row(symbol) for symbol in score.symbols(part)] for part in score.tracks}


def mirrored_rows(score: Score) -> dict[str, list[Row]]:
    """Return the rows that the mirror image of a score has."""
    return {
        mirrored_part(part): [
            (direction and DIRECTIONS[MIRRORED[DIRECTION_CODES[direction]]], *rest)
            for direction, *rest in found
        ]
        for part, found in rows(score).items()
    }


def changed_tracks(one: dict[str, list[Row]], other: dict[str, list[Row]]) -> list[str]:
    """Return the parts whose rows differ."""
    return sorted(part for part in one.keys() | other.keys() if one.get(part) != other.get(part))
