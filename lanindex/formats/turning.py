"""Rotations as unit quaternions (w, x, y, z), and trees of joints that they turn."""

from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.people import distinct

Floats = NDArray[np.float64]

UNTURNED = np.array([[1.0, 0.0, 0.0, 0.0]])
UNSCALED = np.ones((1, 3))


def product(first: NDArray[Any], second: NDArray[Any]) -> Floats:
    """Return the turns (..., 4) that `second` makes, then `first`."""
    w, x, y, z = _parts(first)
    a, b, c, d = _parts(second)
    return _joined(
        w * a - x * b - y * c - z * d,
        w * b + x * a + y * d - z * c,
        w * c - x * d + y * a + z * b,
        w * d + x * c - y * b + z * a,
    )


def _parts(vectors: NDArray[Any]) -> list[NDArray[Any]]:
    """Return the numbers of vectors (..., W), one array each."""
    vectors = np.asarray(vectors)
    return [vectors[..., axis] for axis in range(vectors.shape[-1])]


def _joined(*parts: NDArray[Any]) -> NDArray[Any]:
    """Return arrays of one shape as vectors (..., W): what `numpy.stack` does, in half the time."""
    result = np.empty((*parts[0].shape, len(parts)), parts[0].dtype)
    for axis, part in enumerate(parts):
        result[..., axis] = part
    return result


def inverse(turns: NDArray[Any]) -> Floats:
    """Return the turns (..., 4) that undo some."""
    undone: Floats = np.asarray(turns) * np.array([1.0, -1.0, -1.0, -1.0])
    return undone


def of_vectors(vectors: NDArray[Any]) -> Floats:
    """Return the quaternions (..., 4) of axes times angles (..., 3), radians."""
    angle = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    half = np.sinc(angle / (2 * np.pi)) / 2  # sin(angle / 2) / angle, at 0 too
    return np.concatenate((np.cos(angle / 2), vectors * half), axis=-1)


def rotated(turns: NDArray[Any], points: NDArray[Any]) -> NDArray[Any]:
    """Return points (..., 3) as turns (..., 4) take them."""
    w, x, y, z = _parts(turns)
    a, b, c = _parts(points)
    d, e, f = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return _joined(a + w * d + y * f - z * e, b + w * e + z * d - x * f, c + w * f + x * e - y * d)


def unit(turns: NDArray[Any]) -> Floats:
    """Return turns of length 1; what has no length, or none that is known, does not turn."""
    turns = np.asarray(turns, np.float64)
    length = np.sqrt((turns * turns).sum(axis=-1, keepdims=True))
    sound = length > 1e-12
    return np.where(sound, turns / np.where(sound, length, 1), [1.0, 0.0, 0.0, 0.0])


def between(start: Floats, stop: Floats, part: Floats) -> Floats:
    """Return the turns (T, 4) that are a part (T,) of the shortest way from some to others."""
    cosine = (start * stop).sum(axis=1)
    stop = np.where(cosine[:, None] < 0, -stop, stop)
    angle = np.arccos(np.clip(np.abs(cosine), 0, 1))
    sine = np.sin(angle)
    near = sine < 1e-6
    sine = np.where(near, 1, sine)
    first = np.where(near, 1 - part, np.sin((1 - part) * angle) / sine)
    second = np.where(near, part, np.sin(part * angle) / sine)
    return unit(first[:, None] * start + second[:, None] * stop)


def matrices(turns: NDArray[Any]) -> Floats:
    """Return (..., 3, 3) rotations of unit quaternions."""
    w, x, y, z = _parts(np.asarray(turns, np.float64))
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return _joined(*(number for row in rows for number in row)).reshape(*w.shape, 3, 3)


def quaternions(turns: NDArray[Any]) -> Floats:
    """Return the unit quaternions of rotations (..., 3, 3)."""
    turns = np.asarray(turns, np.float64)
    a, b, c = turns[..., 0, 0], turns[..., 1, 1], turns[..., 2, 2]
    # four ways to the same turn, each up to a factor: the longest is the most exact
    x = turns[..., 2, 1] - turns[..., 1, 2]
    y = turns[..., 0, 2] - turns[..., 2, 0]
    z = turns[..., 1, 0] - turns[..., 0, 1]
    xy = turns[..., 0, 1] + turns[..., 1, 0]
    xz = turns[..., 0, 2] + turns[..., 2, 0]
    yz = turns[..., 1, 2] + turns[..., 2, 1]
    ways = np.stack(
        [
            np.stack([1 + a + b + c, x, y, z], axis=-1),
            np.stack([x, 1 + a - b - c, xy, xz], axis=-1),
            np.stack([y, xy, 1 - a + b - c, yz], axis=-1),
            np.stack([z, xz, yz, 1 - a - b + c], axis=-1),
        ],
        axis=-2,
    )
    diagonal = np.stack([1 + a + b + c, 1 + a - b - c, 1 - a + b - c, 1 - a - b + c], axis=-1)
    best = diagonal.argmax(axis=-1)[..., None, None]
    return unit(np.take_along_axis(ways, best, axis=-2)[..., 0, :])


@dataclass(frozen=True, slots=True)
class JointTree:
    """The joints of one person among the nodes of a file."""

    joints: tuple[int, ...]  # (J) nodes, parents before children
    names: tuple[str, ...]  # (J) each its own
    parents: tuple[int, ...]  # (J) joints by their places in this tree, -1 for a root


def joint_tree(
    joints: Sequence[int], names: Sequence[str], parents: Sequence[int], passed: Container[int] = ()
) -> JointTree:
    """Return the tree of some nodes, by names and parents of all; nodes passed by are left out."""
    place, above = dict[int, int](), list[int]()
    for number, joint in enumerate(joints):
        node = parents[joint]
        while node >= 0 and node not in place and node in passed:
            node = parents[node]
        above.append(place.get(node, -1))
        place[joint] = number
    called = distinct([names[joint] for joint in joints], joints)
    return JointTree(tuple(joints), called, tuple(above))


def ancestry(joints: Iterable[int], parents: Sequence[int]) -> set[int]:
    """Return nodes and all nodes above them."""
    found = set[int]()
    for node in joints:
        while node >= 0 and node not in found:
            found.add(node)
            node = parents[node]
    return found


def from_parents(places: Floats, parents: Sequence[int]) -> Floats:
    """Return places (J, 3) as seen from each joint's parent; of a root as they are."""
    offsets = places.copy()
    below = [joint for joint, parent in enumerate(parents) if parent >= 0]
    offsets[below] -= places[[parents[joint] for joint in below]]
    return offsets


def place(
    joints: Sequence[int],
    order: Sequence[int],
    parents: Sequence[int],
    standing: Callable[[int], tuple[Floats, Floats, Floats]],
    points: NDArray[Any],
    turned: NDArray[Any],
    rest: Floats | None = None,
) -> None:
    """Write positions `points` (T, J, 3) and rotations `turned` (T, J, 4) from `rest` (J, 4).

    `order` holds the joints and the nodes above them, parents before children; `standing` gives a
    node's shift (T, 3), rotation (T, 4) and scale (T, 3) within its parent.
    """
    numbers = {node: number for number, node in enumerate(joints)}
    back = None if rest is None else inverse(rest)
    known: dict[int, tuple[Floats, Floats, Floats | None]] = {}
    last = {parents[node]: node for node in order}
    for node in order:
        parent = parents[node]
        point, turn, scale = standing(node)
        own, above = turn, None
        if parent >= 0:
            base, whole, above = known[parent]
            moved = rotated(whole, point) if above is None else (above @ point[:, :, None])[:, :, 0]
            point, turn = base + moved, whole if own is UNTURNED else product(whole, own)
        axes = None  # without scales, turns say all
        if above is not None or (scale != 1).any():
            axes = matrices(own) * scale[:, None, :]
            if parent >= 0:
                axes = (matrices(whole) if above is None else above) @ axes
        if node in last:
            known[node] = point, turn, axes
        if last[parent] == node:  # held only as long as something stands in it
            known.pop(parent, None)
        if node in numbers:
            joint = numbers[node]
            points[:, joint] = point
            turned[:, joint] = turn if back is None else product(turn, back[joint])


def without_flips(turns: Floats) -> Floats:
    """Return turns (T, ..., 4), each of the sign that is nearer to the one before."""
    flips = (turns[1:] * turns[:-1]).sum(axis=-1) < 0
    odd = np.cumsum(flips, axis=0) % 2 == 1
    result = turns.copy()
    result[1:][odd] *= -1
    return result
