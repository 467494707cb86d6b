"""Turns that positions do not tell: of heads and hands of a motion that knows more of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.body import sampled
from lanindex.body.facing import TURNING, rest_axes, seen_axes
from lanindex.body.palms import rest_palms
from lanindex.model import Motion

Floats = NDArray[np.float64]


def resting(motion: Motion, offsets: NDArray[Any], turned: Floats) -> dict[str, tuple[int, Floats]]:
    """Return where axes point at rest that a motion knows, and the joints that they turn with.

    Takes `offsets` (J, 3), `turned` (S, J, 3, 3).
    """
    skeleton, some = motion.skeleton, sampled(len(motion))
    parents, body = skeleton.parents.tolist(), skeleton.body
    found = rest_palms(skeleton.names, parents, offsets, body)
    rest = rest_axes(parents, offsets, body)
    if rest is None:
        poses = motion.positions[some].astype(np.float64)
        rest = seen_axes(parents, body, poses, lambda joint: turned[:, joint])
    if rest is not None:
        found |= {name: (int(body[JOINT_CODES[name]]), rest) for name in TURNING}
    return {name: it for name, it in found.items() if name in motion.axes}


def aim(
    rest: Mapping[str, tuple[int, Floats]],
    axes: Mapping[str, NDArray[np.float32]],
    frames: slice,
    turns: Floats,
) -> None:
    """Turn joints as far as axes tell it, in place."""
    for name, (joint, own) in rest.items():
        there = axes[name][frames].astype(np.float64)
        known = np.isfinite(there).all(axis=(1, 2))
        then = np.swapaxes(_frames(own[None]), 1, 2)
        turns[known, joint] = _frames(there[known]) @ then


def _frames(axes: Floats) -> Floats:
    """Return two axes and what is at right angles to them, exactly, as the columns of (T, 3, 3)."""
    first, third = axes[:, 0], np.cross(axes[:, 0], axes[:, 1])
    first, third = (it / np.linalg.norm(it, axis=1, keepdims=True) for it in (first, third))
    return np.stack((first, np.cross(third, first), third), axis=2)
