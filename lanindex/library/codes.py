"""The fields of symbols ↔ the whole numbers of a library, all derived from one table.

Small numbers share a column, each with bits of its own (`lanindex.model.symbol.FIELDS` says
where), so that a symbol takes a dozen bytes; the view that `view_sql` makes of them shows words.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS
from lanindex.model.symbol import FIELDS, SYMBOL, Field

Integers = NDArray[np.int64]

COLUMNS = tuple(dict.fromkeys(how.column for how in FIELDS.values()))
"""The columns of ``symbol_code`` that hold fields, in the order of `pack`."""

VIEW = "symbol"
"""The view in words."""

KIND_NAMES = tuple(KINDS)
"""By code."""


def _whole(name: str, symbols: NDArray[Any]) -> NDArray[Any]:
    """Return (S,) a field before its bits are placed; a float that is no number stays one."""
    how = FIELDS[name]
    if how.scale != 1:
        return np.rint(symbols[name].astype(np.float64) * how.scale)
    values: Integers = symbols[name].astype(np.int64)
    return values - symbols[how.since] if how.since else values


def wrong(symbols: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which of (S,) symbols hold a number that has no room: (S,) bool."""
    bad = np.zeros(len(symbols), np.bool_)
    for name, how in FIELDS.items():
        values = _whole(name, symbols)
        bad |= ~((values >= how.least) & (values <= how.most))
    return bad


def pack(symbols: NDArray[Any]) -> Integers:
    """Return (S,) symbols as a library stores them: (S, C) int64, in the order of `COLUMNS`."""
    packed = np.zeros((len(symbols), len(COLUMNS)), np.int64)
    for name, how in FIELDS.items():
        values = _whole(name, symbols).astype(np.int64, copy=False)
        packed[:, COLUMNS.index(how.column)] |= (values - how.least) << how.shift
    return packed


def unpack(packed: Integers) -> NDArray[Any]:
    """Return (S,) symbols from what a library stores: (S, C) int64."""
    symbols = np.empty(len(packed), SYMBOL)
    for name, how in FIELDS.items():
        values = (packed[:, COLUMNS.index(how.column)] >> how.shift) & ((1 << how.bits) - 1)
        if how.least:
            values += how.least
        if how.since:
            values += symbols[how.since]
        symbols[name] = values if how.scale == 1 else values / how.scale
    return symbols


def nameless(packed: Integers) -> NDArray[np.bool_]:
    """Return which of (S, C) packed symbols hold a code that stands for no word: (S,) bool.

    Nothing else that `pack` gives is `wrong`, but an end behind all frames.
    """
    bad = np.zeros(len(packed), np.bool_)
    for how in FIELDS.values():
        if how.words:
            code = packed[:, COLUMNS.index(how.column)] >> how.shift & (1 << how.bits) - 1
            bad |= code > how.most - how.least
    return bad


def view_sql() -> str:
    """Return the statement that makes the view ``symbol``, which shows symbols in words."""
    shown = [_expression(name, how) for name, how in FIELDS.items()]
    kind = f"{_words('t.kind', KIND_NAMES)} AS kind"
    columns = ["c.capture_id", "t.part", "c.ordinal", *shown, kind]
    return (
        f"CREATE VIEW {VIEW} AS SELECT {', '.join(columns)} FROM symbol_code c "
        "JOIN track t ON t.capture_id = c.capture_id AND t.ordinal = c.track"
    )


def _expression(name: str, how: Field) -> str:
    text, shown = f"c.{how.column}", how.shown or name
    if shown == how.column:
        return text
    if sum(how.column == other.column for other in FIELDS.values()) > 1:
        text = f"({text} >> {how.shift})" if how.shift else text
        text = f"({text} & {(1 << how.bits) - 1})"
    if how.words:
        text = _words(text, how.words, -how.least)
    elif how.least:  # the code 0 stands for nothing
        text = f"(NULLIF({text}, 0) - {-how.least})"
    if how.scale != 1:
        text = f"{text} / {how.scale}.0"
    if how.since:
        text = f"c.{FIELDS[how.since].column} + {text}"
    return f"{text} AS {shown}"


def _words(text: str, words: tuple[str, ...], first: int = 0) -> str:
    cases = (f"WHEN {code} THEN '{word}'" for code, word in enumerate(words, first))
    return f"CASE {text} {' '.join(cases)} END"
