"""Turns as unit quaternions (w, x, y, z)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def product(first: NDArray[Any], second: NDArray[Any]) -> Floats:
    """Return the turns (..., 4) that `second` makes, then `first`.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.turning import product
    >>> half = np.array([0.0, 0, 1, 0])  # about y
    >>> product(half, half)
    array([-1.,  0.,  0.,  0.])
    """
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


def rotated(turns: NDArray[Any], points: NDArray[Any]) -> NDArray[Any]:
    """Return points (..., 3) as turns (..., 4) take them.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.turning import rotated
    >>> rotated(np.array([0.0, 0, 0, 1]), np.array([1.0, 2, 3]))  # half a turn about z
    array([-1., -2.,  3.])
    """
    w, x, y, z = _parts(turns)
    a, b, c = _parts(points)
    d, e, f = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return _joined(
        a + w * d + y * f - z * e,
        b + w * e + z * d - x * f,
        c + w * f + x * e - y * d,
    )


def unit(turns: NDArray[Any]) -> Floats:
    """Return turns of length 1; what has no length, or none that is known, does not turn.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.turning import unit
    >>> unit(np.array([[0.0, 0, 3, 4], [0, 0, 0, 0]]))
    array([[0. , 0. , 0.6, 0.8],
           [1. , 0. , 0. , 0. ]])
    """
    turns = np.asarray(turns, np.float64)
    length = np.sqrt((turns * turns).sum(axis=-1, keepdims=True))
    sound = length > 1e-12
    return np.where(sound, turns / np.where(sound, length, 1), [1.0, 0.0, 0.0, 0.0])


def between(start: Floats, stop: Floats, part: Floats) -> Floats:
    """Return turns on the shortest way from some to others, evenly.

    Takes `start, stop` (T, 4), `part` (T,); returns (T, 4).

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.turning import between
    >>> between(np.array([[1.0, 0, 0, 0]]), np.array([[0.0, 1, 0, 0]]), np.array([1 / 3]))
    array([[0.8660254, 0.5      , 0.       , 0.       ]])
    """
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
    """Return the unit quaternions of rotations (..., 3, 3).

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.turning import quaternions
    >>> quaternions(np.diag([-1.0, 1.0, -1.0]))
    array([0., 0., 1., 0.])
    """
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


def worlds(
    nodes: Iterable[tuple[int, int]], standing: Callable[[int], tuple[Floats, Floats, Floats]]
) -> Iterator[tuple[int, Floats, Floats]]:
    """Yield where nodes are and how they are turned.

    Takes `standing` (T, 3), (T, 4); returns (T, 3), (T, 4).

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.turning import worlds
    >>> up, half = np.array([[0.0, 1, 0]]), np.array([[0.0, 0, 0, 1]])  # half a turn about z
    >>> [point.tolist() for _, point, _ in worlds([(0, -1), (1, 0)], lambda _: (up, half, up + 1))]
    [[[0.0, 1.0, 0.0]], [[0.0, -1.0, 0.0]]]
    """
    known: dict[int, tuple[Floats, Floats, Floats | None]] = {}
    nodes = list(nodes)
    last = {parent: node for node, parent in nodes}
    for node, parent in nodes:
        point, turn, scale = standing(node)
        own = turn
        above = None
        if parent >= 0:
            base, whole, above = known[parent]
            moved = rotated(whole, point) if above is None else _through(above, point)
            point, turn = base + moved, product(whole, own)
        axes = None  # without scales, turns say all
        if above is not None or (scale != 1).any():
            axes = matrices(own) * scale[:, None, :]
            if parent >= 0:
                axes = (matrices(whole) if above is None else above) @ axes
        if node in last:
            known[node] = point, turn, axes
        if last[parent] == node:  # held only as long as something stands in it
            known.pop(parent, None)
        yield node, point, turn


def _through(axes: Floats, points: Floats) -> Floats:
    moved: Floats = (axes @ points[:, :, None])[:, :, 0]
    return moved


def without_flips(turns: Floats) -> Floats:
    """Return turns (T, ..., 4), each of the sign that is nearer to the one before.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.turning import without_flips
    >>> without_flips(np.array([[1.0, 0, 0, 0], [-1, 0, 0, 0], [-1, 0, 0, 0]]))[:, 0]
    array([1., 1., 1.])
    """
    flips = (turns[1:] * turns[:-1]).sum(axis=-1) < 0
    odd = np.cumsum(flips, axis=0) % 2 == 1
    result = turns.copy()
    result[1:][odd] *= -1
    return result
