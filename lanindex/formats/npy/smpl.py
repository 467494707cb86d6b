"""From how the joints of SMPL turn to where they are (AMASS).

Files hold turns and the shape of the body as weights of a model that may not be handed on. Here
all bodies have the mean shape, in millimetres as published with many programs: directions, of
which symbols are made, are exact for the mean body and within a few degrees for others, for the
shape changes how bones lie at rest; lengths may be off by a tenth.

Sources: Loper et al. (2015), *SMPL*, ACM Trans. Graph. 34(6), mean male joints; Mahmood et al.
(2019), *AMASS*, ICCV.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.npy.orders import SMPL
from lanindex.formats.turning import product, rotated

Floats = NDArray[np.float64]

WIDTHS = {66: "SMPL", 72: "SMPL", 156: "SMPL-H", 165: "SMPL-X"}
"""Numbers of a pose: three for each joint; the first 66 are those of the body in all."""

TURNED = 22
"""How many joints turn; the hands of `SMPL` follow their wrists."""

PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21)

REST = (-0.002, -0.241, 0.029)
"""Of the pelvis, metres: where it is when nothing is moved."""

OFFSETS = (
    np.array(
        (
            *((0, 0, 0), (59, -82, -18), (-60, -91, -14), (4, 124, -38)),
            *((43, -386, 8), (-43, -384, -5), (4, 138, 27)),
            *((-15, -427, -37), (19, -420, -35), (-2, 56, 3)),
            *((41, -60, 122), (-35, -62, 130), (-13, 212, -33)),
            *((72, 114, -19), (-83, 112, -24), (10, 89, 50)),
            *((123, 45, -19), (-113, 47, -8), (255, -16, -23), (-260, -14, -31)),
            *((266, 13, -7), (-269, 7, -6), (87, -11, -16), (-89, -9, -10)),
        )
    )
    / 1000.0
)
"""(24, 3) metres, y up, facing z: of each joint from its parent, arms stretched sideways."""

BLOCK = 4096
"""Frames that are turned at a time."""


def placed(poses: NDArray[Any], shift: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return where the joints of `SMPL` are, and how they are turned.

    Takes `shift` (T, 3); returns (T, 24, 3), (T, 24, 4).
    """
    places = np.empty((len(poses), len(SMPL), 3), np.float32)
    turns = np.empty((len(poses), len(SMPL), 4), np.float32)
    for start in range(0, len(poses), BLOCK):
        block = slice(start, start + BLOCK)
        vectors = poses[block, : 3 * TURNED].astype(np.float64).reshape(-1, TURNED, 3)
        _block(quaternions(vectors), shift[block].astype(np.float64), places[block], turns[block])
    return places, turns


def _block(local: Floats, shift: Floats, places: NDArray[Any], turns: NDArray[Any]) -> None:
    world: list[Floats] = []
    at: list[Floats] = []
    for joint, parent in enumerate(PARENTS):
        if parent < 0:
            world.append(local[:, joint])
            at.append(shift + REST)
        else:
            above = world[parent]
            world.append(product(above, local[:, joint]) if joint < TURNED else above)
            at.append(at[parent] + rotated(above, OFFSETS[joint]))
        places[:, joint], turns[:, joint] = at[joint], world[joint]


def quaternions(vectors: Floats) -> Floats:
    """Return axis times angle (..., 3) as quaternions (..., 4), w first."""
    angle = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    half = np.sinc(angle / (2 * np.pi)) / 2  # sin(angle / 2) / angle, at 0 too
    return np.concatenate((np.cos(angle / 2), vectors * half), axis=-1)
