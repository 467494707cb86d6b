"""Rotations: from where joints are to how their bones are turned."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def rotations(points: Floats, offsets: Floats, parents: NDArray[np.int_]) -> Floats:
    """Return how each joint turns its children's offsets.

    A joint with one direction to keep turns on from its parent by the smallest angle; with several
    it is fitted by least squares (Kabsch 1976); with none it follows its parent.

    `points` (T, J, 3) positions; `offsets` (J, 3) from the parent, at rest; `parents` (J,) indices,
    parents before children, -1 for the root; returned (T, J, 3, 3) rotations from rest to the
    world.
    """
    turns = np.empty((*points.shape, 3))
    for joint, parent in enumerate(parents):
        turns[:, joint] = turns[:, parent] if parent >= 0 else np.eye(3)
        children = np.flatnonzero((parents == joint) & (np.abs(offsets).max(axis=1) > 0))
        if not len(children):
            continue
        rest = offsets[children]
        now = points[:, children] - points[:, [joint]]
        if np.linalg.matrix_rank(rest, tol=1e-6 * np.abs(rest).max()) > 1:
            turns[:, joint] = _fitted(rest, now)
        else:
            carried = turns[:, joint] @ rest[0]
            turns[:, joint] = _smallest(carried, now[:, 0]) @ turns[:, joint]
    return turns


def _fitted(rest: Floats, now: Floats) -> Floats:
    """Return the rotations (T, 3, 3) that take (C, 3) nearest to (T, C, 3)."""
    left, _, right = np.linalg.svd(np.einsum("tci,cj->tij", now, rest))
    flip = np.ones((len(now), 1, 3))
    flip[:, 0, 2] = np.linalg.det(left @ right)
    turns: Floats = (left * flip) @ right
    return turns


def _smallest(start: Floats, stop: Floats) -> Floats:
    """Return the smallest rotations (T, 3, 3) from one direction (T, 3) to another."""
    start, stop = _unit(start), _unit(stop)
    axis, cosine = np.cross(start, stop), np.sum(start * stop, axis=1)
    sine = np.linalg.norm(axis, axis=1)
    opposite = (sine < 1e-9) & (cosine < 0)
    axis = _unit(axis)
    cross = np.zeros((len(start), 3, 3))
    for row, column, source in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
        cross[:, row, column], cross[:, column, row] = axis[:, source], -axis[:, source]
    along, square = sine[:, None, None], (1 - cosine)[:, None, None]
    turns: Floats = np.eye(3) + along * cross + square * (cross @ cross)
    if opposite.any():  # half a turn about the vertical; from up to down about x
        upright = np.array([0.0, 1.0, 0.0]) - start[opposite, 1:2] * start[opposite]
        vague = np.linalg.norm(upright, axis=1) < 1e-6
        upright[vague] = [1.0, 0.0, 0.0]
        about = _unit(upright)
        turns[opposite] = 2 * about[:, :, None] * about[:, None, :] - np.eye(3)
    return turns


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Floats = vectors / np.where(length > 0, length, 1)
    return unit


def euler(turns: Floats) -> Floats:
    """Return angles about z, then x, then y, each about the axes as turned before.

    `turns` (T, ..., 3, 3) rotations, Rz · Rx · Ry; returned (T, ..., 3) degrees z, x, y, without
    jumps of a whole turn over time.
    """
    flat = np.hypot(turns[..., 0, 1], turns[..., 1, 1])
    locked = flat < 1e-9
    z = np.where(
        locked,
        np.arctan2(turns[..., 1, 0], turns[..., 0, 0]),
        np.arctan2(-turns[..., 0, 1], turns[..., 1, 1]),
    )
    x = np.arctan2(turns[..., 2, 1], flat)
    y = np.where(locked, 0.0, np.arctan2(-turns[..., 2, 0], turns[..., 2, 2]))
    angles = np.degrees(np.stack([z, x, y], axis=-1))
    steady: Floats = np.unwrap(angles, axis=0, period=360)
    return steady
