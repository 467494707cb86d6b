"""Texts of captures as columns of a segment: paths, labels, metadata.

Filters look at the texts of all captures, so segments hold them too: one list of JSON a column,
with a checksum. Whoever changes a text marks the capture as not covered by its segment.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library import columns, read, segments, state
from lanindex.library.link import Link
from lanindex.library.segments import Distrust, Segment, Spine
from lanindex.library.selection import Texts
from lanindex.model import Capture

NAMES = segments.TEXTS
"""The columns."""

_ATTRIBUTES = ("path", "location", "format", "label", "metadata")
"""Those that are attributes of a `Capture`."""

EMPTY: dict[str, Any] = dict.fromkeys(NAMES, "") | {"metadata": {}, "still": []}
"""The values of a capture that has none."""


def texts_of(captures: Sequence[Capture]) -> dict[str, list[Any]]:
    """Return the texts of captures by column."""
    return {name: [getattr(capture, name) for capture in captures] for name in _ATTRIBUTES}


def spelled(texts: Texts) -> list[tuple[str, NDArray[np.uint8]]]:
    """Return texts as the JSON columns of a segment."""
    lists = ((name, json.dumps(list(texts[name]), ensure_ascii=False)) for name in NAMES)
    return [
        (name, np.frombuffer(text.encode("utf-8", "surrogatepass"), np.uint8))
        for name, text in lists
    ]


def read_all_texts(
    connection: Link, spine: Spine, names: Sequence[str]
) -> tuple[list[int], dict[str, Sequence[Any]]]:
    """Return the numbers of all captures, in order, and their texts by name of the column."""
    rosters, order = columns.read_rosters(connection, spine)
    pieces = [read_texts(connection, one, names) for one in spine.segments]
    pieces.append(of_rows(connection, spine.pending, names))
    numbers = [number for roster in rosters for number in roster.number.tolist()]
    return taken([*numbers, *spine.pending], order), together(pieces, names, order)


def together(
    pieces: Sequence[Texts], names: Iterable[str], order: NDArray[np.int64] | None
) -> dict[str, Sequence[Any]]:
    """Return the texts of all pieces, joined; `order` selects and sorts the captures."""
    return {
        name: taken([value for piece in pieces for value in piece[name]], order) for name in names
    }


def taken(values: list[Any], order: NDArray[np.int64] | None) -> list[Any]:
    """Return the values at the places of `order`, or all of them."""
    return values if order is None else [values[place] for place in order.tolist()]


def read_texts(connection: Link, segment: Segment, names: Iterable[str] = NAMES) -> Texts:
    """Return the texts of a segment's captures, dead ones included."""
    return {name: _column(connection, segment, name) for name in names}


def _column(connection: Link, segment: Segment, name: str) -> Sequence[Any]:
    stored, found = segments.read_column(connection, segment, "", name), None
    with suppress(ValueError):  # it was stored so, with its checksum
        found = json.loads(stored.tobytes())
    if not isinstance(found, list) or len(found) != segment.captures:
        raise Distrust(f"damaged: {name} of the captures in segment {segment.id}")
    return found


def of_rows(
    connection: Link, numbers: Sequence[int], names: Iterable[str] = NAMES
) -> dict[str, list[Any]]:
    """Return the texts of captures from their rows; `EMPTY` for deleted captures."""
    found: dict[str, list[Any]] = {name: [] for name in names}
    for first in range(0, len(numbers), state.MOST):
        some = numbers[first : first + state.MOST]
        held = read.read_captures(connection, some)
        wanted = read.read_wanted(connection, held) if "still" in found else None
        for name, values in found.items():
            texts = of_read(name, held, wanted)
            values += [texts.get(number, EMPTY[name]) for number in some]
    return found


def of_read(
    name: str, held: Iterable[read.Stored], wanted: read.Tracks | None
) -> Mapping[int, Any]:
    """Return one column of captures by number; "still" needs their tracks.

    Captures without a value are left out.
    """
    if name == "profile":
        return {one.capture.id: one.encoding.profile for one in held}
    if name != "still" or wanted is None:
        return {one.capture.id: getattr(one.capture, name) for one in held}
    still: dict[int, list[str]] = {}
    for track in np.flatnonzero(np.array(wanted.symbols) == 0).tolist():
        if wanted.known[track] is None:
            number = wanted.chosen[wanted.place[track]].capture.id
            still.setdefault(number, []).append(wanted.part[track])
    return still
