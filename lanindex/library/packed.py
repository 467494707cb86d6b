"""Rows of symbols in few numbers: handing a number over costs more than reading it.

What has 31 bits shares a number with what has 31, and which row it is need not be handed over: the
rows of a track stand in order, and its checksum is over their places, too. So whatever is not as it
was stored is noticed, though not told: for that the rows are read again, one by one.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, Connection, Integer, Select, select, type_coerce

from lanindex.library import checksums, codes, rows, schema

_BITS = 31
_PAIRED = (("start", "length"), ("tick", "ticks"))
"""Columns of whole numbers of at most so many bits, which share a number."""

_ALONE = tuple(name for name in codes.COLUMNS if not any(name in pair for pair in _PAIRED))
_ORDER = [codes.COLUMNS.index(name) for name in (*chain(*_PAIRED), *_ALONE)]
"""The places in `codes.COLUMNS` of what is handed over."""

_CODE = schema.symbol_code.c


def _both(high: str, low: str) -> ColumnElement[int]:
    shifted = type_coerce(_CODE[high], Integer).bitwise_lshift(_BITS)
    return shifted.bitwise_or(_CODE[low])


@cache
def _rows() -> Select[Any]:
    """Return what asks for all rows; a search that reads none does without."""
    columns = *(_both(*pair) for pair in _PAIRED), *(_CODE[name] for name in _ALONE)
    return select(*columns).order_by(*schema.symbol_code.primary_key.columns)


def read_fields(
    connection: Connection,
    captures: Sequence[int],
    tracks: Sequence[tuple[int, int, int]],
    *,
    every: bool,
) -> NDArray[np.int64] | None:
    """Return the fields of all rows of some tracks: (S, C) int64, in the order of `codes.COLUMNS`.

    Parameters
    ----------
    connection : Connection
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
    chosen = _rows().where(_CODE.capture_id.in_(captures))
    if not every:
        chosen = chosen.where(_CODE.track.in_({track for track, _, _ in tracks}))
    found: Any = connection.execute(chosen).cursor  # straight from the driver, a row at a time
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
    content, first = np.ascontiguousarray(numbers, "<i8").reshape(-1).view(np.uint8).data, 0
    for _, count, checksum in tracks:
        last = first + 8 * numbers.shape[1] * count
        if checksums.of_bytes(content[first:last]) != checksum:
            return None
        first = last
    return numbers[:, 2:]


def _unpacked(handed: NDArray[np.int64]) -> NDArray[np.int64]:
    fields = np.empty((len(handed), len(codes.COLUMNS)), np.int64)
    pairs, low = handed[:, : len(_PAIRED)], (1 << _BITS) - 1
    both = np.stack([pairs >> _BITS, pairs & low], axis=2).reshape(len(handed), 2 * len(_PAIRED))
    fields[:, _ORDER] = np.concatenate([both, handed[:, len(_PAIRED) :]], axis=1)
    return fields
