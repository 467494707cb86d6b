"""Rows of symbols in few numbers: handing a number over costs more than reading it.

What has 31 bits shares a number with what has 31, and which row it is need not be handed over: the
rows of a track stand in order, and its checksum is over their places, too. So whatever is not as it
was stored is noticed, though not told: for that the rows are read again, one by one.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from lanindex.library import codes, rows
from lanindex.library.link import Link, among, ask

_BITS = 31
_PAIRED = (("start", "length"), ("tick", "ticks"))
"""Columns of whole numbers of at most so many bits, which share a number."""

_ALONE = tuple(name for name in codes.COLUMNS if not any(name in pair for pair in _PAIRED))
_ORDER = [codes.COLUMNS.index(name) for name in (*chain(*_PAIRED), *_ALONE)]
"""The places in `codes.COLUMNS` of what is handed over."""

_TAKEN = [f"({high} << {_BITS}) | {low}" for high, low in _PAIRED] + list(_ALONE)
_ROWS = f"SELECT {', '.join(_TAKEN)} FROM symbol_code"


def read_fields(
    connection: Link,
    captures: Sequence[int],
    tracks: Sequence[tuple[int, int, int]],
    *,
    every: bool,
) -> NDArray[np.int64] | None:
    """Return the fields of all rows of some tracks: (S, C) int64, in the order of `codes.COLUMNS`.

    Parameters
    ----------
    connection : Link
        In a transaction.
    captures : sequence of int
        The numbers of the captures.
    tracks : sequence of (int, int, int)
        Those of their tracks that are to be read: ordinal, how many symbols, and their checksum.
    every : bool
        Whether they have no other tracks.

    Returns
    -------
    ndarray or None
        None where they are not what was stored, or more.
    """
    chosen = f"capture_id IN {among(captures)}"
    if not every:
        chosen += f" AND track IN {among({track for track, _, _ in tracks})}"
    found = ask(connection, f"{_ROWS} WHERE {chosen} ORDER BY capture_id, track, ordinal")
    try:
        handed = np.fromiter(chain.from_iterable(found), np.int64)
    except (TypeError, ValueError, OverflowError):  # that is no whole number
        return None
    counts = [count for _, count, _ in tracks]
    width = len(_PAIRED) + len(_ALONE)
    if len(handed) != sum(counts) * width:
        return None
    numbers = rows.numbered(_unpacked(handed.reshape(-1, width)), counts)
    numbers[:, 0] = np.repeat(np.array([track for track, _, _ in tracks], np.int64), counts)
    as_stored = rows.of_tracks(numbers, counts) == [checksum for _, _, checksum in tracks]
    return numbers[:, 2:] if as_stored else None


def _unpacked(handed: NDArray[np.int64]) -> NDArray[np.int64]:
    fields = np.empty((len(handed), len(codes.COLUMNS)), np.int64)
    pairs, low = handed[:, : len(_PAIRED)], (1 << _BITS) - 1
    both = np.stack([pairs >> _BITS, pairs & low], axis=2).reshape(len(handed), 2 * len(_PAIRED))
    fields[:, _ORDER] = np.concatenate([both, handed[:, len(_PAIRED) :]], axis=1)
    return fields
