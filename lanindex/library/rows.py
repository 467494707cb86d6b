"""Score ↔ rows of ``track`` and ``symbol``: whole tracks at a time, column by column."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.errors import LibraryError, UsageError
from lanindex.model import SYMBOL, Meter, Score, Span, Track
from lanindex.model.symbol import blank

FIELDS: dict[str, tuple[str, tuple[str, ...] | None]] = {
    "direction": ("direction", DIRECTIONS),
    "level": ("level", LEVELS),
    "start": ("start_frame", None),
    "stop": ("end_frame", None),
    "tick": ("tick", None),
    "ticks": ("ticks", None),
    "passing": ("passing", None),
    "rule": ("rule", None),
    "swings": ("swings", None),
    "margin": ("margin", None),
    "runner_direction": ("runner_direction", DIRECTIONS),
    "runner_level": ("runner_level", LEVELS),
}
"""By field of ``model.SYMBOL``: its column, and the words that its codes stand for."""

COLUMNS = ("capture_id", "part", "ordinal", *(column for column, _ in FIELDS.values()))
"""The columns of ``symbol`` in the order of the rows made and read here."""

OPTIONAL = {"runner_direction", "runner_level"}
"""Fields whose code may be -1, stored as null."""

_CODES = {
    field: {word: code for code, word in enumerate(words)}
    | ({None: -1} if field in OPTIONAL else {})
    for field, (_, words) in FIELDS.items()
    if words
}


def check(score: Score, place: str) -> None:
    """Refuse a score that cannot be stored as it is.

    Raises
    ------
    UsageError
        If a code has no word, or a symbol lies outside the score's frames.
    """
    for part, track in score.tracks.items():
        if track.part != part:
            raise UsageError(f"{part} holds the track of {track.part}", place=place)
    symbols = _joined(score.tracks.values())
    start, stop = symbols["start"], symbols["stop"]
    wrong = (start < 0) | (stop < start) | (stop > score.frames)
    for field, (_, words) in FIELDS.items():
        if words is not None:
            least = -1 if field in OPTIONAL else 0
            wrong |= (symbols[field] < least) | (symbols[field] >= len(words))
    if wrong.any():
        row = int(wrong.argmax())
        parts = [part for part, track in score.tracks.items() for _ in range(len(track))]
        raise UsageError(
            f"{parts[row]} has the symbol {symbols[row]}",
            place=place,
            wanted=f"codes of the alphabet and a span within {score.frames} frames",
        )


def _joined(tracks: Iterable[Track]) -> NDArray[Any]:
    # Naming the dtype spares numpy a slow search for one that all have in common.
    arrays = [track.symbols for track in tracks]
    return np.concatenate(arrays, dtype=SYMBOL) if arrays else np.empty(0, SYMBOL)


def track_rows(capture_id: int, score: Score) -> list[tuple[Any, ...]]:
    """Return the rows of ``track``: capture, part, ordinal, known stretches."""
    return [
        (capture_id, part, ordinal, json.dumps([[span.start, span.stop] for span in track.known]))
        for ordinal, (part, track) in enumerate(score.tracks.items())
    ]


def symbol_rows(capture_id: int, score: Score) -> list[tuple[Any, ...]]:
    """Return the rows of ``symbol``, in the order of `COLUMNS` and of the table's key."""
    tracks = sorted(score.tracks.items())  # rows that come in order fill whole pages
    symbols = _joined(track for _, track in tracks)
    parts = [part for part, track in tracks for _ in range(len(track))]
    ordinals = [ordinal for _, track in tracks for ordinal in range(len(track))]
    columns = [_stored(symbols[field], words) for field, (_, words) in FIELDS.items()]
    return list(zip([capture_id] * len(parts), parts, ordinals, *columns, strict=True))


def _stored(values: NDArray[Any], words: tuple[str, ...] | None) -> list[Any]:
    if words is None:
        return list(values.tolist())
    return list(np.array([*words, None], object)[values].tolist())


def read_symbols(
    rows: Sequence[tuple[Any, ...]],
) -> dict[tuple[int, str], NDArray[Any]]:
    """Return the symbols of each track from rows of ``symbol``.

    Parameters
    ----------
    rows : sequence of tuple
        In the order of `COLUMNS`, tracks one after the other, each by ordinal.

    Returns
    -------
    dict
        Capture and part to (S,) array of dtype ``model.SYMBOL``.

    Raises
    ------
    LibraryError
        If a row holds a word that the alphabet lacks.
    """
    if not rows:
        return {}
    captures, parts, ordinals, *columns = zip(*rows, strict=True)
    symbols = blank(len(rows))
    for field, column in zip(FIELDS, columns, strict=True):
        symbols[field] = _coded(field, column)
    borders = [*np.flatnonzero(np.array(ordinals) == 0).tolist(), len(rows)]
    return {
        (captures[start], parts[start]): symbols[start:stop] for start, stop in pairwise(borders)
    }


def _coded(field: str, column: Sequence[Any]) -> NDArray[Any]:
    codes = _CODES.get(field)
    try:
        if codes is None:
            return np.array(column, "f8" if field == "margin" else "i8")
        return np.array([codes[word] for word in column], "i1")
    except (KeyError, TypeError, ValueError) as error:
        raise LibraryError(
            f"a symbol of the library has an unknown {field}: {error}",
            remedy="Ask it for what is wrong with: lanindex db check",
        ) from error


def read_tracks(
    listed: Iterable[Any], symbols: dict[tuple[int, str], NDArray[Any]]
) -> dict[int, dict[str, Track]]:
    """Return the tracks of each capture.

    Parameters
    ----------
    listed : iterable of tuple
        Capture, part and known stretches (JSON), in the order of the tracks.
    symbols : dict
        From `read_symbols`.
    """
    captures: dict[int, dict[str, Track]] = {}
    for capture_id, part, known in listed:
        rows = symbols.get((capture_id, part))
        captures.setdefault(capture_id, {})[part] = Track(
            part,
            np.empty(0, SYMBOL) if rows is None else rows,
            tuple(Span(start, stop) for start, stop in json.loads(known)),
        )
    return captures


def capture_columns(score: Score) -> dict[str, Any]:
    """Return what a row of ``capture`` says of a score."""
    meter = score.meter
    return {
        "fps": float(score.rate),
        "rate": str(score.rate),
        "frames": score.frames,
        "speed": str(meter.speed),
        "beats": meter.beats,
        "beat": meter.beat,
        "division": meter.division,
        "other": json.dumps(score.other),
        "heading": score.heading.astype("<f4").tobytes(),
    }


def read_meter(row: Any) -> Meter:
    """Return the meter of a row of ``capture``."""
    return Meter(Fraction(row.speed), row.beats, row.beat, row.division)


def read_heading(blob: bytes) -> NDArray[np.float32]:
    """Return the heading: (N,) float32, degrees."""
    return np.frombuffer(blob, "<f4").astype(np.float32)
