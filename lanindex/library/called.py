"""What captures are called, as columns: paths, labels and whatever else the user says of them.

Which captures somebody means is asked of all of them. So what names them stands in the segments,
too, a list of JSON for each column, and is trusted as the others are: whoever changes it of a
capture says that the segments do not hold that one any more.
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

_SAID = ("path", "location", "format", "label", "metadata")
"""Those that are attributes of a capture."""

NOTHING: dict[str, Any] = dict.fromkeys(NAMES, "") | {"metadata": {}, "still": []}
"""What they say where there is nothing to be said."""


def texts_of(captures: Sequence[Capture]) -> dict[str, list[Any]]:
    """Return what captures are called."""
    return {name: [getattr(capture, name) for capture in captures] for name in _SAID}


def spelled(texts: Texts) -> list[tuple[str, NDArray[np.uint8]]]:
    """Return what captures are called as the columns that a segment keeps."""
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
    """Return what captures are called, one piece after the other, those that count in order."""
    return {
        name: taken([value for piece in pieces for value in piece[name]], order) for name in names
    }


def taken(values: list[Any], order: NDArray[np.int64] | None) -> list[Any]:
    """Return those values that count, in order; None: all, as they are."""
    return values if order is None else [values[place] for place in order.tolist()]


def read_texts(connection: Link, segment: Segment, names: Iterable[str] = NAMES) -> Texts:
    """Return what the captures of a segment are called, dead ones too."""
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
    """Return what captures are called by their rows; of those that are gone, nothing."""
    found: dict[str, list[Any]] = {name: [] for name in names}
    for first in range(0, len(numbers), state.MOST):
        some = numbers[first : first + state.MOST]
        held = read.read_captures(connection, some)
        wanted = read.read_wanted(connection, held) if "still" in found else None
        for name, values in found.items():
            texts = of_read(name, held, wanted)
            values += [texts.get(number, NOTHING[name]) for number in some]
    return found


def of_read(
    name: str, held: Iterable[read.Stored], wanted: read.Tracks | None
) -> Mapping[int, Any]:
    """Return what one column says of captures that have been read, for "still" with their tracks.

    By their numbers; of those that have nothing to say of it there is none.
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
