"""Rows of symbols in one text: handing numbers over one by one costs more than reading them.

SQLite spells the numbers of all rows as characters, and Python takes these for numbers again. Which
row it is need not be handed over: the rows of a track stand in order, and its checksum is over
their places, too. So whatever is not as it was stored is noticed, though not told: for that the
rows are read again, one by one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex.library import rows
from lanindex.library.connect import is_sqlite
from lanindex.library.link import Link, among, ask

_BITS = 20
"""A character has room for so many."""

_FULL = 1 << _BITS
_LOW = (f"sign % {_FULL}", f"notes % {_FULL}")
_MIDDLE = (f"sign / {_FULL} % {_FULL}", f"notes / {_FULL} % {_FULL}")  # faster than shift and mask
_HIGH = (f"sign >> {2 * _BITS}", f"notes >> {2 * _BITS}")  # below 0 where the number is
_SHORT = ("start", "length", "tick", "ticks")
_CHARACTERS = (*_LOW, *_MIDDLE, *_HIGH, *_SHORT)
"""Long numbers take three characters; almost all of the others fit into one."""

_SPELLED = (
    f"SELECT CAST(group_concat(char({', '.join(_CHARACTERS)}), '') AS BLOB) FROM symbol_code "
    "WHERE +sign < '' AND +notes < '' AND"
)
"""What is no number is left out, and so it is missed. The plus signs keep SQLite from trying to
make a number of the text, row by row."""

_NONE = 0xFFFD
"""What SQLite takes for a character that there is not."""

_FITS = f"({' | '.join(_SHORT)}) >> {_BITS} = 0 AND"


def read_fields(
    connection: Link,
    captures: Sequence[int],
    ordinals: Sequence[int],
    counts: Sequence[int],
    checksums: Sequence[int],
    *,
    every: bool,
) -> NDArray[np.int64] | None:
    """Return the fields of all rows of some tracks: (S, C) int64, ordered as `codes.COLUMNS`."""
    if not is_sqlite(connection):
        return None
    chosen = f"capture_id IN {among(captures)}"
    if not every:
        chosen += f" AND track IN {among({*ordinals})}"
    handed = _handed(connection, f"{_SPELLED} {chosen}")
    if (handed[:, len(_LOW + _MIDDLE) :] == _NONE).any():
        handed = _handed(connection, f"{_SPELLED} {_FITS} {chosen}")
    if len(handed) != sum(counts):
        return None
    numbers = rows.numbered(_joined(handed), counts, ordinals)
    return numbers[:, 2:] if rows.of_tracks(numbers, counts) == [*checksums] else None


def _handed(connection: Link, asked: str) -> NDArray[np.uint32]:
    ((text,),) = ask(connection, asked)
    spelled = (text or b"").decode("utf-8", "surrogatepass").encode("utf-32-le", "surrogatepass")
    return np.frombuffer(spelled, "<u4").reshape(-1, len(_CHARACTERS))


def _joined(handed: NDArray[np.uint32]) -> NDArray[np.int64]:
    wide = handed.astype(np.int64)
    sign_notes = wide[:, :2] | wide[:, 2:4] << _BITS | wide[:, 4:6] << 2 * _BITS
    return np.concatenate((sign_notes[:, :1], wide[:, 6:], sign_notes[:, 1:]), axis=1)
