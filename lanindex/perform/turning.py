"""How the standard body twists and leans: chest against pelvis, head against chest.

Source: ``encode/BODY.md``, "Twists" and "Inclines", read backwards. Directions are vectors of the
body frame: forward +x, up +y, right +z.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PLACE
from lanindex.model import SYMBOL, Score
from lanindex.perform.reach import minimum_jerk

Floats = NDArray[np.float64]

TURNED = ("torso_twist", "head_turn", "torso_incline", "head_incline")
"""The tracks that are carried out here."""

_SLIGHT = 1e-6  # a part of a unit vector that tells no direction


def angles(score: Score, part: str, times: Floats) -> NDArray[np.complex128]:
    r"""Return how far a part is turned, or leans, to the right, and (imaginary) forward.

    `times`: (T,) seconds; returns (T,) complex128, degrees.
    """
    rows: Any = score.tracks[part].symbols if part in score.tracks else np.zeros(0, SYMBOL)
    found, now = np.zeros(len(times), np.complex128), 0j
    for row in rows[~rows["passing"]]:
        start, stop = (float(Fraction(int(row[end])) / score.rate) for end in ("start", "stop"))
        some = slice(int(np.searchsorted(times, start)), None)
        there = _angle(int(row["direction"]), int(row["amount"]))
        share = np.clip((times[some] - start) / max(stop - start, 1e-9), 0, 1)
        found[some] = now + (there - now) * minimum_jerk(share)
        now = there
    return found


def _angle(code: int, degrees: int) -> complex:
    if not 0 <= code < PLACE or degrees < 0:
        return 0j
    return complex(degrees * np.exp(1j * np.radians(45 * code)))


def leaning(lean: NDArray[np.complex128]) -> Floats:
    """Return where something points that leans so far, (T, 3) unit vectors."""
    size = np.abs(lean)
    way = lean / np.maximum(size, _SLIGHT)
    flat = np.sin(np.radians(size))
    return np.stack((flat * way.imag, np.cos(np.radians(size)), flat * way.real), axis=1)


def twisted(trunk: Floats, twist: Floats) -> tuple[Floats, Floats]:
    """Return where the chest's front and right point.

    `trunk`: (T, 3) unit vectors; `twist`: (T,) degrees to the right of the pelvis, about the trunk.
    """
    right = np.array([0.0, 0.0, 1.0])
    across = right - trunk[:, 2:] * trunk
    size = np.linalg.norm(across, axis=1, keepdims=True)
    aside = size < _SLIGHT  # as the torso lay down on its side, its right went down
    across = np.where(aside, -np.sign(trunk[:, 2:]) * [0.0, 1.0, 0.0], across / (size + aside))
    front = np.cross(trunk, across)
    cosine, sine = np.cos(np.radians(twist))[:, None], np.sin(np.radians(twist))[:, None]
    return cosine * front + sine * across, cosine * across - sine * front


def head_right(up: Floats, trunk: Floats, across: Floats) -> Floats:
    """Return where the right of a head points that is turned so far about the trunk.

    `up`: (T, 3) unit vectors; `trunk, across`: (T, 3) unit vectors.
    """
    along = np.sum(up * trunk, axis=1, keepdims=True)
    along = np.where(np.abs(along) < _SLIGHT, _SLIGHT, along)
    right = across - np.sum(up * across, axis=1, keepdims=True) / along * trunk
    found: Floats = right / np.linalg.norm(right, axis=1, keepdims=True)
    return found
